//! Closed-form fields.
