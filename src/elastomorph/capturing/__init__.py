"""Photographs and scans become poses that share one topology."""
