//! Residual views for `compare`.
