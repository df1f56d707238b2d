"""Verify, design and compare TDE control of robot arms on a Pinocchio ground truth."""
