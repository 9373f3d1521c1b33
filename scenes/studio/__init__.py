"""`lce studio`: a local page to plan, predict and compare, on top of the very commands of `lce`."""
