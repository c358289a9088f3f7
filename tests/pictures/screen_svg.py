"""A terminal's screen (pyte) as SVG: every cell in its place, with its colours."""

from xml.sax.saxutils import escape

CELL_WIDTH, CELL_HEIGHT, FONT = 8.4, 18, 14  # px; a monospaced letter is 0.6 of its size wide
BACKGROUND, FOREGROUND = "#1c1f26", "#d8dee9"
COLOURS = {"black": "#15171c", "red": "#ff6b6b", "green": "#8fce6a", "brown": "#f2c14e", "blue": "#2b5c9e",
           "magenta": "#c792ea", "cyan": "#56c8d8", "white": "#f4f6fa"}
BLOCKS = "▁▂▃▄▅▆▇█"  # drawn as boxes: fonts differ in how high they are


def colour(name, otherwise):
    return otherwise if name == "default" else COLOURS.get(name, "#" + name)


def look(cell):
    """Colours and weight of a cell: foreground, background, bold, underlined."""
    front, back = colour(cell.fg, FOREGROUND), colour(cell.bg, BACKGROUND)
    return (back, front, cell.bold, cell.underscore) if cell.reverse else (front, back, cell.bold, cell.underscore)


def runs(line, columns):
    """The cells of a line in pieces that look alike: column, text, look."""
    start, text, seen = 0, "", None
    for column in range(columns):
        cell = line[column]
        if look(cell) != seen and text:
            yield start, text, seen
            start, text = column, ""
        seen = look(cell)
        text += cell.data
    yield start, text, seen


def block(x, y, character, front):
    """A block element as a box that stands on the line's lower edge."""
    height = CELL_HEIGHT * 0.8 * (BLOCKS.index(character) + 1) / len(BLOCKS)
    top = y + CELL_HEIGHT * 0.9 - height
    return f'<rect x="{x:.1f}" y="{top:.1f}" width="{CELL_WIDTH - 0.6:.1f}" height="{height:.1f}" fill="{front}"/>'


def draw_run(row, column, text, seen):
    front, back, bold, underlined = seen
    x, y, width = 12 + column * CELL_WIDTH, 40 + row * CELL_HEIGHT, len(text) * CELL_WIDTH
    out = []
    if back != BACKGROUND:
        # A little wider than it is, so that nothing shines through between two pieces of the same colour.
        out.append(f'<rect x="{x:.1f}" y="{y}" width="{width + 0.6:.1f}" height="{CELL_HEIGHT}" fill="{back}"/>')
    if underlined:
        out.append(f'<rect x="{x:.1f}" y="{y + CELL_HEIGHT - 2}" width="{width:.1f}" height="1" fill="#5b6472"/>')
    letters = "".join(" " if c in BLOCKS + "░" else c for c in text)
    for index, character in enumerate(text):
        if character in BLOCKS:
            out.append(block(x + index * CELL_WIDTH, y, character, front))
        elif character == "░":
            out.append(f'<rect x="{x + index * CELL_WIDTH:.1f}" y="{y + 9:.1f}" width="{CELL_WIDTH - 0.6:.1f}" height="2" '
                       'fill="#4a5160"/>')
    # A word at a time: wherever the viewer's font is wider or narrower, words stand in their columns.
    at = 0
    for word in letters.split(" "):
        if word:
            weight = ' font-weight="bold"' if bold else ""
            out.append(f'<text x="{x + at * CELL_WIDTH:.1f}" y="{y + 13.5:.1f}" fill="{front}"{weight} '
                       f'textLength="{len(word) * CELL_WIDTH:.1f}" lengthAdjust="spacingAndGlyphs">{escape(word)}</text>')
        at += len(word) + 1
    return out


def screen_svg(screen, title):
    """The screen in a window with this title."""
    width, height = screen.columns * CELL_WIDTH + 24, screen.lines * CELL_HEIGHT + 52
    out = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {width:.0f} {height:.0f}">',
        f"<title>{escape(title)}</title>",
        f"<style>text{{font-family:'DejaVu Sans Mono',monospace;font-size:{FONT}px;white-space:pre}}</style>",
        f'<rect width="{width:.0f}" height="{height:.0f}" rx="8" fill="{BACKGROUND}"/>',
        f'<text x="{width / 2:.0f}" y="23" fill="#8b93a1" text-anchor="middle">{escape(title)}</text>',
    ]
    for index, dot in enumerate(("#ff6b6b", "#f2c14e", "#8fce6a")):
        out.append(f'<circle cx="{20 + index * 18}" cy="18" r="5.5" fill="{dot}"/>')
    for row in range(screen.lines):
        for column, text, seen in runs(screen.buffer[row], screen.columns):
            if text.strip() or seen[1] != BACKGROUND:
                out += draw_run(row, column, text.rstrip() if seen[1] == BACKGROUND and not seen[3] else text, seen)
    out.append("</svg>")
    return "\n".join(out) + "\n"
