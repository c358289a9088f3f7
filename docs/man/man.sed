# What lowdown writes in man(7), as mandoc and groff want it without a warning.
# Headings on the line of their macro; the paragraph after them begins by itself.
/^\.S[HS]$/{
N
N
s/^\(\.S[HS]\)\n\(.*\)\n\.[LP]P$/\1 \2/
s/^\(\.S[HS]\)\n/\1 /
}
# A terminal has no font of constant width: code is bold there.
s/\\fC/\\fB/g
# Other documents are named, not addressed by their place in the repository.
s/ <\\fI[^>]*\.md[^>]*\\fR>//g
# Narrow columns are not stretched to even margins, and names in them are not broken.
/^\.TH/a\
.ad l\
.nh
