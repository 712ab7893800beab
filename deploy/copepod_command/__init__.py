"""The Copepod command: prepares the machine, starts the three processes of a run, watches them, shows the result."""
