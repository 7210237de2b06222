"""Cameras, surfaces and what moves them."""
