"""From a Program to what devices do: operations, journal, interlocks, executor."""
