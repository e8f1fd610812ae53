"""Tests of the dynamic-bumper MPC."""
