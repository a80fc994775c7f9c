//! What the six components of a contact's force and moment are called.

/// Label and unit of each component of a contact's force and moment, in C axes.
pub const COMPONENTS: [(&str, &str); 6] = [
    ("x", "N"),
    ("y", "N"),
    ("normal", "N"),
    ("moment x", "N·m"),
    ("moment y", "N·m"),
    ("moment z", "N·m"),
];
