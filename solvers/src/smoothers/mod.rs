//! smoothers
