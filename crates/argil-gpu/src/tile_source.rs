//! How passes that fill tiles evaluate the field: a sample at a time, by the whole program or by lists, or three samples of a
//! column.

use crate::bindings::{Bind, COLUMNS_WGSL, FIELD_BINDS, LISTS, PARAMS, TABLES_WGSL};
use crate::near_lists::field_tables;
use argil_volume::wgsl;

/// How the field is evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
enum TileKind {
    Whole,
    Columns,
    Lists,
}

/// WGSL that evaluates the field for `fill_tile`.
pub(crate) struct TileSource {
    wgsl: String,
    kind: TileKind,
}

impl TileSource {
    /// Evaluates any program, by the interpreter's WGSL.
    pub(crate) fn of_any(wgsl: impl Into<String>) -> Self {
        let (wgsl, kind) = (wgsl.into(), TileKind::Whole);
        Self { wgsl, kind }
    }

    /// Evaluates a program of common instructions, by [`argil_field::Interpreter::column_wgsl`].
    pub(crate) fn of_columns(wgsl: String) -> Self {
        let kind = TileKind::Columns;
        Self { wgsl, kind }
    }

    /// Evaluates any program by lists, by [`argil_field::Interpreter::near_wgsl`].
    pub(crate) fn of_lists(wgsl: String) -> Self {
        let kind = TileKind::Lists;
        Self { wgsl, kind }
    }

    /// Whether a sample takes the whole program.
    pub(crate) fn is_whole(&self) -> bool {
        self.kind == TileKind::Whole
    }

    /// Returns one of three names: for whole programs, for columns and for lists.
    pub(crate) fn name_of(&self, names: [&'static str; 3]) -> &'static str {
        names[self.kind as usize]
    }

    /// Returns the tables of the program, as the shader names them.
    pub(crate) fn tables(&self) -> String {
        match self.kind {
            TileKind::Whole => TABLES_WGSL.into(),
            TileKind::Columns => COLUMNS_WGSL.into(),
            TileKind::Lists => field_tables(true).1,
        }
    }

    /// Returns the bindings of these tables.
    pub(crate) fn binds(&self) -> Vec<Bind> {
        match self.kind {
            TileKind::Whole => FIELD_BINDS.to_vec(),
            TileKind::Columns => vec![Bind::Read(LISTS), Bind::Read(PARAMS)],
            TileKind::Lists => field_tables(true).0,
        }
    }

    /// Returns the WGSL that evaluates the field, and that of `fill_tile`.
    pub(crate) fn wgsl(&self) -> [&str; 2] {
        let fill = match self.kind {
            TileKind::Columns => wgsl::BAKE_LEVEL_BY_COLUMNS,
            TileKind::Whole | TileKind::Lists => wgsl::BAKE_LEVEL,
        };
        [&self.wgsl, fill]
    }
}
