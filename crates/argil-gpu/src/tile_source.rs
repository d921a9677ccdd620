//! How passes that fill tiles evaluate the field: a sample at a time, or three samples of a column.

use crate::bindings::{Bind, COLUMNS_WGSL, FIELD_BINDS, LISTS, PARAMS, TABLES_WGSL};
use argil_volume::wgsl;

/// WGSL that evaluates the field for `fill_tile`.
pub(crate) struct TileSource {
    wgsl: String,
    by_columns: bool,
}

impl TileSource {
    /// Evaluates any program, by the interpreter's WGSL.
    pub(crate) fn of_any(wgsl: impl Into<String>) -> Self {
        Self {
            wgsl: wgsl.into(),
            by_columns: false,
        }
    }

    /// Evaluates a program of common instructions, by [`argil_field::Interpreter::column_wgsl`].
    pub(crate) fn of_columns(wgsl: String) -> Self {
        Self {
            wgsl,
            by_columns: true,
        }
    }

    /// Returns one of two names: that for any program, or that for columns.
    pub(crate) fn name_of(&self, [any, columns]: [&'static str; 2]) -> &'static str {
        if self.by_columns { columns } else { any }
    }

    /// Returns the tables of the program, as the shader names them.
    pub(crate) fn tables(&self) -> &'static str {
        if self.by_columns {
            COLUMNS_WGSL
        } else {
            TABLES_WGSL
        }
    }

    /// Returns the bindings of these tables.
    pub(crate) fn binds(&self) -> Vec<Bind> {
        if self.by_columns {
            vec![Bind::Read(LISTS), Bind::Read(PARAMS)]
        } else {
            FIELD_BINDS.to_vec()
        }
    }

    /// Returns the WGSL that evaluates the field, and that of `fill_tile`.
    pub(crate) fn wgsl(&self) -> [&str; 2] {
        let fill = if self.by_columns {
            wgsl::BAKE_LEVEL_BY_COLUMNS
        } else {
            wgsl::BAKE_LEVEL
        };
        [&self.wgsl, fill]
    }
}
