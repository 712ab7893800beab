"""Broken: prints its capabilities at once, but never sends a Hello."""

import json
import sys
import time

if "--capabilities" in sys.argv:
    print(json.dumps({"name": "Silent fluid", "version": "1.0", "role": "fluid", "features": []}))
else:
    time.sleep(600)
