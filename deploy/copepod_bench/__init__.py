"""Measurements of this machine for `copepod bench`: the fluid beside the memory, coupled beside uncoupled."""
