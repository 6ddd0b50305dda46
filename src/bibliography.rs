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
//!
//! # Wei & Levoy 2001
//! L.-Y. Wei, M. Levoy: *Texture synthesis over arbitrary manifold surfaces.* Proceedings of ACM
//! SIGGRAPH, 355–360, 2001.
//!
//! # MeshMatch 2012
//! X. Chen, T. Funkhouser, D. B. Goldman, E. Shechtman: *Non-parametric texture transfer using
//! MeshMatch.* Adobe Technical Report 2012-2, 2012.
//!
//! # Zelinka & Garland 2004
//! S. Zelinka, M. Garland: *Similarity-based surface modelling using geodesic fans.* Symposium on Geometry
//! Processing (SGP), 204–213, 2004.
//!
//! # PatchMatch 2009
//! C. Barnes, E. Shechtman, A. Finkelstein, D. B. Goldman: *PatchMatch: a randomized correspondence
//! algorithm for structural image editing.* ACM Transactions on Graphics 28(3), 24, 2009.
//!
//! # Image analogies 2001
//! A. Hertzmann, C. E. Jacobs, N. Oliver, B. Curless, D. H. Salesin: *Image analogies.* Proceedings
//! of ACM SIGGRAPH, 327–340, 2001.
//!
//! # Ashikhmin 2001
//! M. Ashikhmin: *Synthesizing natural textures.* Proceedings of the ACM Symposium on Interactive 3D
//! Graphics, 217–226, 2001.
//!
//! # Tong et al. 2002
//! X. Tong, J. Zhang, L. Liu, X. Wang, B. Guo, H.-Y. Shum: *Synthesis of bidirectional texture
//! functions on arbitrary surfaces.* ACM Transactions on Graphics 21(3), 665–672, 2002.
//!
//! # Lefebvre & Hoppe 2005
//! S. Lefebvre, H. Hoppe: *Parallel controllable texture synthesis.* ACM Transactions on Graphics 24(3), 777–786, 2005.
//!
//! # Kaspar et al. 2015
//! A. Kaspar, B. Neubert, D. Lischinski, M. Pauly, J. Kopf: *Self tuning texture optimization.* Computer Graphics Forum
//! 34(2), 349–359, 2015.
//!
//! # Lucas & Kanade 1981
//! B. D. Lucas, T. Kanade: *An iterative image registration technique with an application to stereo
//! vision.* International Joint Conference on Artificial Intelligence (IJCAI), 674–679, 1981.
//!
//! # Pérez et al. 2003
//! P. Pérez, M. Gangnet, A. Blake: *Poisson image editing.* ACM Transactions on Graphics 22(3),
//! 313–318, 2003.
//!
//! # Bhat et al. 2008
//! P. Bhat, B. Curless, M. Cohen, C. L. Zitnick: *Fourier analysis of the 2D screened Poisson equation
//! for gradient domain problems.* European Conference on Computer Vision (ECCV), 114–128, 2008.
//!
//! # Liepa 2003
//! P. Liepa: *Filling holes in meshes.* Eurographics Symposium on Geometry Processing, 200–205, 2003; the
//! triangulation of least weight is that of G. Barequet, M. Sharir: *Filling gaps in the boundary of a
//! polyhedron.* Computer Aided Geometric Design 12(2), 207–229, 1995.
//!
//! # Botsch & Kobbelt 2004
//! M. Botsch, L. Kobbelt: *A remeshing approach to multiresolution modeling.* Eurographics Symposium on
//! Geometry Processing, 185–192, 2004.
//!
//! # Bergou et al. 2006
//! M. Bergou, M. Wardetzky, D. Harmon, D. Zorin, E. Grinspun: *A quadratic bending model for inextensible
//! surfaces.* Eurographics Symposium on Geometry Processing, 227–230, 2006.
//!
//! # Hoppe et al. 1992
//! H. Hoppe, T. `DeRose`, T. Duchamp, J. `McDonald`, W. Stuetzle: *Surface reconstruction from unorganized
//! points.* Computer Graphics (Proceedings of ACM SIGGRAPH) 26(2), 71–78, 1992.
//!
//! # Gopi, Krishnan & Silva 2000
//! M. Gopi, S. Krishnan, C. T. Silva: *Surface reconstruction based on lower dimensional localized Delaunay
//! triangulation.* Computer Graphics Forum (Proceedings of Eurographics) 19(3), 467–478, 2000.
//!
//! # Sun, Ovsjanikov & Guibas 2009
//! J. Sun, M. Ovsjanikov, L. Guibas: *A concise and provably informative multi-scale signature based on heat
//! diffusion.* Computer Graphics Forum (Symposium on Geometry Processing) 28(5), 1383–1392, 2009.
//!
//! # Crane, Weischedel & Wardetzky 2013
//! K. Crane, C. Weischedel, M. Wardetzky: *Geodesics in heat: a new approach to computing distance based on heat
//! flow.* ACM Transactions on Graphics 32(5), 152, 2013.
//!
//! # Sharp & Crane 2020
//! N. Sharp, K. Crane: *A Laplacian for nonmanifold triangle meshes.* Computer Graphics Forum (Symposium on
//! Geometry Processing) 39(5), 69–80, 2020.
