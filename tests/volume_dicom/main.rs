//! DICOM: real files against SimpleITK; series that the tests write; damage.

mod damage;
mod file;
mod real;
mod refused;
mod series;
mod syntaxes;
