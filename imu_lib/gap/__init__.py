"""Where simulation and measurement disagree: find it, name it, add it, show that the gap shrinks, go on."""
