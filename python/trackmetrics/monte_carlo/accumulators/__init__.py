"""Accumulators: statistics over runs that merge in any order to the same bits."""
