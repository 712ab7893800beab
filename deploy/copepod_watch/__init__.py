"""`copepod watch`: a run directory as a live page, on this machine only."""
