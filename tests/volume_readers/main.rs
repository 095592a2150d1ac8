//! Volume files against SimpleITK and VTK as readers: those that are written, and real ones.

mod readers;
mod real;
mod write;
