"""Reports from run directories: tables and plots as PNG files and one self-contained HTML page."""
