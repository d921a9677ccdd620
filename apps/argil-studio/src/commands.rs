//! The commands: their names, menus and shortcuts.

use eframe::egui::{Key, KeyboardShortcut, Modifiers};

/// A command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[allow(
    missing_docs,
    reason = "names of commands say what they do, and the table has them in words"
)]
pub(crate) enum Command {
    New,
    Open,
    Save,
    SaveAs,
    Import,
    ExportMesh,
    ExportPicture,
    ExportTurntable,
    ExportVolume,
    Quit,
    Undo,
    Redo,
    Cut,
    Copy,
    Paste,
    Duplicate,
    Delete,
    Group,
    Ungroup,
    Hide,
    Lock,
    Rename,
    SelectAll,
    SelectNone,
    MirrorX,
    MirrorY,
    MirrorZ,
    NudgeLeft,
    NudgeRight,
    NudgeUp,
    NudgeDown,
    NudgeNearer,
    NudgeFarther,
    Select,
    Move,
    Rotate,
    Scale,
    SculptAdd,
    SculptCarve,
    SculptSmooth,
    SculptPaint,
    LocalSpace,
    Snap,
    FrameSelection,
    FrameAll,
    Front,
    Right,
    Top,
    Ortho,
    Grid,
    Readings,
    Split,
    Difference,
    Paths,
    ZoomIn,
    ZoomOut,
    ZoomReset,
    Theme,
    History,
    Palette,
    Help,
}

/// A command's row in the menus.
pub(crate) struct CommandInfo {
    /// The command.
    pub command: Command,
    /// The menu.
    pub menu: &'static str,
    /// The label.
    pub name: &'static str,
    /// The default shortcut.
    pub shortcut: Option<KeyboardShortcut>,
}

const fn entry(
    command: Command,
    menu: &'static str,
    name: &'static str,
    shortcut: Option<KeyboardShortcut>,
) -> CommandInfo {
    CommandInfo {
        command,
        menu,
        name,
        shortcut,
    }
}

const fn key(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::NONE, key))
}

const fn ctrl(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::COMMAND, key))
}

const fn shift(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::SHIFT, key))
}

const CTRL_SHIFT: Modifiers = Modifiers {
    shift: true,
    ..Modifiers::COMMAND
};

const fn ctrl_shift(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(CTRL_SHIFT, key))
}

/// The menus, from left to right.
pub(crate) const MENUS: [&str; 5] = ["File", "Edit", "Tool", "View", "Help"];

/// All commands, in menu order.
pub(crate) const ALL: &[CommandInfo] = &[
    entry(Command::New, "File", "New", ctrl(Key::N)),
    entry(Command::Open, "File", "Open…", ctrl(Key::O)),
    entry(Command::Save, "File", "Save", ctrl(Key::S)),
    entry(Command::SaveAs, "File", "Save as…", ctrl_shift(Key::S)),
    entry(
        Command::Import,
        "File",
        "Import mesh or volume…",
        ctrl(Key::I),
    ),
    entry(Command::ExportMesh, "File", "Export mesh…", ctrl(Key::E)),
    entry(
        Command::ExportPicture,
        "File",
        "Export image…",
        ctrl(Key::P),
    ),
    entry(Command::ExportTurntable, "File", "Export turntable…", None),
    entry(Command::ExportVolume, "File", "Export volume…", None),
    entry(Command::Quit, "File", "Quit", ctrl(Key::Q)),
    entry(Command::Undo, "Edit", "Undo", ctrl(Key::Z)),
    entry(Command::Redo, "Edit", "Redo", ctrl_shift(Key::Z)),
    entry(Command::History, "Edit", "History", ctrl(Key::H)),
    entry(Command::Cut, "Edit", "Cut", ctrl(Key::X)),
    entry(Command::Copy, "Edit", "Copy", ctrl(Key::C)),
    entry(Command::Paste, "Edit", "Paste", ctrl(Key::V)),
    entry(Command::Duplicate, "Edit", "Duplicate", ctrl(Key::D)),
    entry(Command::Delete, "Edit", "Delete", key(Key::Delete)),
    entry(Command::Group, "Edit", "Group", ctrl(Key::G)),
    entry(Command::Ungroup, "Edit", "Ungroup", ctrl_shift(Key::G)),
    entry(Command::Hide, "Edit", "Hide or show", key(Key::H)),
    entry(Command::Lock, "Edit", "Lock or unlock", key(Key::L)),
    entry(Command::Rename, "Edit", "Rename", key(Key::F2)),
    entry(Command::SelectAll, "Edit", "Select all", ctrl(Key::A)),
    entry(
        Command::SelectNone,
        "Edit",
        "Deselect all",
        key(Key::Escape),
    ),
    entry(Command::MirrorX, "Edit", "Mirror at x = 0", None),
    entry(Command::MirrorY, "Edit", "Mirror at y = 0", None),
    entry(Command::MirrorZ, "Edit", "Mirror at z = 0", None),
    entry(
        Command::NudgeLeft,
        "Edit",
        "Nudge left",
        shift(Key::ArrowLeft),
    ),
    entry(
        Command::NudgeRight,
        "Edit",
        "Nudge right",
        shift(Key::ArrowRight),
    ),
    entry(Command::NudgeUp, "Edit", "Nudge up", shift(Key::ArrowUp)),
    entry(
        Command::NudgeDown,
        "Edit",
        "Nudge down",
        shift(Key::ArrowDown),
    ),
    entry(
        Command::NudgeNearer,
        "Edit",
        "Nudge forward",
        shift(Key::PageDown),
    ),
    entry(
        Command::NudgeFarther,
        "Edit",
        "Nudge back",
        shift(Key::PageUp),
    ),
    entry(Command::Select, "Tool", "Select", key(Key::Q)),
    entry(Command::Move, "Tool", "Move", key(Key::W)),
    entry(Command::Rotate, "Tool", "Rotate", key(Key::E)),
    entry(Command::Scale, "Tool", "Scale", key(Key::R)),
    entry(Command::SculptAdd, "Tool", "Sculpt: add", key(Key::Num1)),
    entry(
        Command::SculptCarve,
        "Tool",
        "Sculpt: carve",
        key(Key::Num2),
    ),
    entry(
        Command::SculptSmooth,
        "Tool",
        "Sculpt: smooth",
        key(Key::Num3),
    ),
    entry(
        Command::SculptPaint,
        "Tool",
        "Sculpt: paint",
        key(Key::Num4),
    ),
    entry(Command::LocalSpace, "Tool", "Local axes", key(Key::X)),
    entry(Command::Snap, "Tool", "Snap", key(Key::S)),
    entry(
        Command::FrameSelection,
        "View",
        "Frame selection",
        key(Key::F),
    ),
    entry(Command::FrameAll, "View", "Frame all", key(Key::Home)),
    entry(Command::Front, "View", "Front or back", key(Key::F5)),
    entry(Command::Right, "View", "Right or left", key(Key::F6)),
    entry(Command::Top, "View", "Top or bottom", key(Key::F7)),
    entry(
        Command::Ortho,
        "View",
        "Orthographic projection",
        key(Key::O),
    ),
    entry(Command::Grid, "View", "Grid and axes", key(Key::G)),
    entry(Command::Readings, "View", "Statistics", key(Key::I)),
    entry(Command::Split, "View", "Split view", key(Key::V)),
    entry(Command::Difference, "View", "Difference", shift(Key::V)),
    entry(Command::Paths, "View", "Path-traced still", key(Key::P)),
    entry(Command::ZoomIn, "View", "Larger interface", ctrl(Key::Plus)),
    entry(
        Command::ZoomOut,
        "View",
        "Smaller interface",
        ctrl(Key::Minus),
    ),
    entry(
        Command::ZoomReset,
        "View",
        "Reset interface scale",
        ctrl(Key::Num0),
    ),
    entry(Command::Theme, "View", "Toggle theme", None),
    entry(Command::Palette, "Help", "Find a command…", ctrl(Key::K)),
    entry(Command::Help, "Help", "Shortcuts", key(Key::F1)),
];

/// Returns the row of a command.
pub(crate) fn info(command: Command) -> &'static CommandInfo {
    // The table lists every command; a test checks it.
    ALL.iter().find(|e| e.command == command).unwrap_or(&ALL[0])
}

/// Parses a shortcut such as `Ctrl+Shift+Z`.
pub(crate) fn parse(text: &str) -> Option<KeyboardShortcut> {
    let mut modifiers = Modifiers::NONE;
    let mut parts = text.split('+').map(str::trim).peekable();
    while let Some(part) = parts.next() {
        let is_last = parts.peek().is_none();
        match part.to_ascii_lowercase().as_str() {
            "ctrl" | "cmd" | "command" if !is_last => {
                modifiers = modifiers.plus(Modifiers::COMMAND)
            }
            "shift" if !is_last => modifiers = modifiers.plus(Modifiers::SHIFT),
            "alt" if !is_last => modifiers = modifiers.plus(Modifiers::ALT),
            _ if is_last => {
                let key = Key::from_name(part)?;
                return Some(KeyboardShortcut::new(modifiers, key));
            }
            _ => return None,
        }
    }
    None
}

/// Formats a shortcut so that it can be parsed again.
pub(crate) fn format_shortcut(shortcut: &KeyboardShortcut) -> String {
    let m = shortcut.modifiers;
    let mut text = String::new();
    for (is_held, word) in [
        (m.command || m.ctrl, "Ctrl+"),
        (m.shift, "Shift+"),
        (m.alt, "Alt+"),
    ] {
        if is_held {
            text += word;
        }
    }
    text + shortcut.logical_key.name()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_command_is_there_once_and_no_shortcut_is_twice() {
        let commands: BTreeSet<Command> = ALL.iter().map(|e| e.command).collect();
        assert_eq!(commands.len(), ALL.len());
        assert_eq!(commands.len(), Command::Help as usize + 1);
        assert!(ALL.iter().all(|e| MENUS.contains(&e.menu)));
        let keys: Vec<String> = ALL
            .iter()
            .flat_map(|e| &e.shortcut)
            .map(format_shortcut)
            .collect();
        let different: BTreeSet<&String> = keys.iter().collect();
        assert_eq!(different.len(), keys.len());
    }

    #[test]
    fn shortcuts_are_read_as_they_are_written() {
        for shortcut in ALL.iter().flat_map(|e| &e.shortcut) {
            let text = format_shortcut(shortcut);
            assert_eq!(parse(&text).as_ref(), Some(shortcut), "{text}");
        }
        for bad in ["", "Ctrl+", "Meta+Z", "Ctrl+Shift", "Zzz"] {
            assert_eq!(parse(bad), None, "{bad}");
        }
    }
}
