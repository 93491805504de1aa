//! The validation report: what `validate --report` writes.
//!
//! Cases of this crate ([`crate::cases`]) are kept in a [`Store`], figures of the papers come from scripts of the Python
//! client ([`SCRIPTS`]), studies from `sturz study` ([`STUDIES`]), and [`page()`] puts all on one self-contained page, with the work-precision plots that cases
//! leave as [`Curve`]s and a table of the stiff and extreme cases.

mod curve;
mod page;
mod scripts;
mod stability;
mod store;
mod studies;

pub use curve::{Curve, draw_all};
pub use page::page;
pub use scripts::{Found, SCRIPTS, Script, ScriptRow};
pub use store::{Record, Store};
pub use studies::{STUDIES, Study, StudyOrder, StudyRecommendation, StudyResult};
