"""Campaigns: a list of cases run as one, several at once, going on where it stopped."""
