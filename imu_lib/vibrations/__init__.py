"""What shakes a record: lines, combs of lines, lines that wander and bands of noise, found over
all channels at once, each with its channels, its times and what it puts into the samples.

`narrow_band` finds places in frequency and time where a channel is louder than around, `sources`
what is behind one place on all channels, `families` lines of one cause, `forest` lines too many
for a cause each, `coherent_band` noise that channels share in a band; `entries` makes entries of a
model of them, `band_removal` takes a band out.
"""
