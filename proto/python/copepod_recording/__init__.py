"""Reads what runs recorded: messages in wire/, phases in trace/ (docs/recording.md)."""
