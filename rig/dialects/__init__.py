"""Dialects: what is said on the wire, as bytes in and events out, without any I/O."""
