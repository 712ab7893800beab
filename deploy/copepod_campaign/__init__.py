"""Campaigns: a list of cases run as one, several at once, resuming where it stopped."""
