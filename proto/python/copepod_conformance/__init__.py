"""Checks any component against docs/protocol.md: plays its coupler, many short lives long. See suite.py."""
