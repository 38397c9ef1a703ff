"""Packets of spinning lidars to point clouds. Pure: bytes and stamps come from outside."""
