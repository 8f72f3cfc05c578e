//! Twinrotor's control core.
#![no_std]
#![forbid(unsafe_code)]
