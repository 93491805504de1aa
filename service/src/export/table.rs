//! Columns of a message, found by name and proved to be of one length.

use sturz_protocol::columns::{self, Number};
use sturz_protocol::v1::Column;

use super::exporter::ExportError;

/// The columns of one message.
pub struct Table<'a> {
    /// Of the message, for errors.
    pub what: &'static str,
    /// Rows of each column.
    pub rows: usize,
    /// As sent.
    pub columns: &'a [Column],
}

impl Table<'_> {
    /// Floats of either width; `None` when the column was not sent.
    pub fn floats<const C: usize>(&self, name: &str) -> Result<Option<Vec<[f64; C]>>, ExportError> {
        self.read(name, columns::read_floats::<C>)
    }

    /// Whole numbers; `None` when the column was not sent.
    pub fn numbers<T: Number, const C: usize>(&self, name: &str) -> Result<Option<Vec<[T; C]>>, ExportError> {
        self.read(name, columns::read::<T, C>)
    }

    /// What cannot be done without.
    pub fn needed<T>(&self, name: &str, column: Option<T>) -> Result<T, ExportError> {
        column.ok_or_else(|| self.error(name, "was not sent or recorded"))
    }

    fn read<R, E: ToString>(
        &self,
        name: &str,
        read: impl FnOnce(&Column) -> Result<Vec<R>, E>,
    ) -> Result<Option<Vec<R>>, ExportError> {
        let Some(column) = self.columns.iter().find(|column| column.name == name) else { return Ok(None) };
        let rows = read(column).map_err(|error| self.error(name, &error.to_string()))?;
        if rows.len() == self.rows {
            Ok(Some(rows))
        } else {
            Err(self.error(name, &format!("has {} rows instead of {}", rows.len(), self.rows)))
        }
    }

    fn error(&self, name: &str, problem: &str) -> ExportError {
        ExportError::Message(format!("column {name:?} of a {} {problem}", self.what))
    }
}
