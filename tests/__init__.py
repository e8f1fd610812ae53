"""Tests of CCAS; the folders mirror the packages."""
