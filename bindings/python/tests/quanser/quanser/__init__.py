"""A stand-in for Quanser's library: the calls that the example makes, on a simulated rig."""
