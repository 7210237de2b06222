"""Photographs: which there are, how they were taken, and their pixels."""
