# What lowdown writes in man(7), as mandoc and groff want it without a warning.
# A terminal has no font of constant width: code is bold there.
s/\\fC/\\fB/g
# Other documents are named, not addressed by their place in the repository.
s/ <\\fI[^>]*\.md[^>]*\\fR>//g
s/ <\\fI#[^>]*\\fR>//g
# Words are not stretched to even margins, and names in them are not broken, but in the narrow columns of tables.
/^\.TH/a\
.ad l\
.nr HY 0
/^\.TS/i\
.hy
# Items without a line between them.
/^\.if n \\$/{
N
N
N
N
s/.*\n\(\.IP.*\)/.PD 0\n\1\n.PD/
}
# Headings on the line of their macro; the paragraph after them begins by itself.
/^\.S[HS]$/{
N
N
s/\\fC/\\fB/g
s/^\(\.S[HS]\)\n\(.*\)\n\.[LP]P$/\1 \2/
s/^\(\.S[HS]\)\n/\1 /
P
D
}
