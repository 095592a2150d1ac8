//! What a mesh measures, of which pieces it is, and what simplification leaves of it: against closed forms and VTK.

mod connect;
mod measure;
mod oracle;
mod shapes;
mod simplify;
