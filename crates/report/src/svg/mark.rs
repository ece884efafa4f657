//! How points and curves of a chart are marked.

/// How a series is drawn; shape and colour say the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Filled blue circles.
    Dot,
    /// Open orange triangles.
    Triangle,
    /// A line, solid blue.
    Line,
    /// A line, dashed orange.
    Dashed,
    /// A line, dotted grey.
    Dotted,
    /// A line, thin black.
    Thin,
}

impl Mark {
    /// The kinds of line, with their class, in the order in which curves take them.
    pub const LINES: [(Self, &'static str); 4] =
        [(Self::Line, "l1"), (Self::Dashed, "l2"), (Self::Dotted, "l3"), (Self::Thin, "l4")];

    pub(super) fn line_class(self) -> Option<&'static str> {
        Self::LINES.iter().find(|(mark, _)| *mark == self).map(|(_, class)| *class)
    }
}

/// The mark of one point.
pub(super) fn symbol(mark: Mark, x: f64, y: f64) -> String {
    if mark == Mark::Dot {
        return format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"1.8\" class=\"m1\"/>\n");
    }
    format!("<path d=\"M{:.1} {:.1}l2.6 4.4h-5.2z\" class=\"m2\"/>\n", x, y - 2.6)
}
