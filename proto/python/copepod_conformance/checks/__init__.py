"""What is checked: one module per group, each with checks(subject) -> list of Check."""
