"""Experiments with a reference, for every scheme at the surfaces of bodies: `copepod validate`."""
