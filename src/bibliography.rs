//! The publications that the code follows, cited from the other rooms as links.
//!
//! # Breckon & Fisher 2005
//! T. P. Breckon, R. B. Fisher: *Non-parametric 3D surface completion.* Fifth International
//! Conference on 3-D Digital Imaging and Modeling (3DIM), 573–580, 2005; extended as
//! *Three-dimensional surface relief completion via nonparametric techniques*, IEEE Transactions on
//! Pattern Analysis and Machine Intelligence 30(12), 2249–2255, 2008.
//!
//! # Efros & Leung 1999
//! A. A. Efros, T. K. Leung: *Texture synthesis by non-parametric sampling.* International
//! Conference on Computer Vision (ICCV), 1033–1038, 1999.
