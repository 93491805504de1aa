//! Cases with references.
