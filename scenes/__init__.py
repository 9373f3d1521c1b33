"""The cases and the only place that composes the other rooms: built-in targets, `lce`, pictures, report."""
