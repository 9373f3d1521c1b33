"""Program -> machine: the stage and the devices around it, simulated or over serial ports."""
