"""Transports: how bytes reach a device, real or simulated."""

from rig.transport.transport import Clock, Transport

__all__ = ["Clock", "Transport"]
