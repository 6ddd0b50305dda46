//! The levels one after the other, the coarsest first.

use crate::progress::{Clock, Progress};
use crate::rng::Rng;

use super::canvas::CanvasLevel;
use super::coherent;
use super::level::{Above, Looks, Painted, Window, Work};
use super::params::{Method, TextureParams};
use super::pyramid::Pyramid;
use super::report::LevelReport;
use super::sites::Sites;
use super::wei_levoy;

/// What stands on the finest level in the end, and what came of each, the finest first.
pub(super) fn paint(
    pyramid: &Pyramid,
    canvas: &[CanvasLevel],
    params: &TextureParams,
    rng: &mut Rng,
    clock: &mut Clock,
) -> (Painted, Vec<LevelReport>) {
    let all: usize = canvas.iter().map(|level| level.normals.len()).sum();
    let mut before = 0;
    let mut done: Option<Painted> = None;
    let mut reports = Vec::new();
    for (number, level) in canvas.iter().enumerate().rev() {
        (clock.progress)(Progress {
            stage: "texture",
            done: before,
            total: all,
        });
        before += level.normals.len();
        let window = Window::of_level(number, canvas.len(), params.method);
        let coarse = canvas.get(number + 1);
        let places = coarse.map(|coarse| {
            coarse.locate(level.surface.positions(), &level.normals, &level.directions)
        });
        let looks = Looks::new(level, coarse.zip(places.as_deref()), &window, params.method);
        clock.end("neighborhoods");
        let sites = Sites::new(
            &pyramid.levels[number],
            pyramid.levels.get(number + 1),
            &window,
            pyramid.channels,
            (params.method == Method::Coherent).then(|| looks.sharpness()),
        );
        clock.end("sample");
        let work = Work {
            canvas: level,
            sites: &sites,
            looks: &looks,
            above: (coarse.zip(done.as_ref()).zip(places.as_deref())).map(
                |((canvas, painted), places)| Above {
                    canvas,
                    painted,
                    places,
                },
            ),
        };
        let mut painted = at_random(&work, rng);
        match params.method {
            Method::WeiLevoy => wei_levoy::run(&work, &mut painted, params.search, rng),
            Method::Coherent => {
                coherent::run(&work, pyramid.levels.get(number + 1), &mut painted, rng);
            }
        }
        clock.end("texture");
        reports.push(report(&work, &painted, &window));
        done = Some(painted);
    }
    reports.reverse();
    (done.expect("there is a level"), reports)
}

/// Values drawn from the sample: each of its sites as often as any other, but for one time.
///
/// # Reference
/// [Wei & Levoy 2001](crate::bibliography#wei--levoy-2001), §3.1: equal histograms.
fn at_random(work: &Work, rng: &mut Rng) -> Painted {
    let sites = u32::try_from(work.sites.len()).expect("sites are u32");
    let mut drawn: Vec<u32> = (0..work.len()).map(|v| v % sites).collect();
    shuffle(&mut drawn, rng);
    let mut painted = Painted {
        sources: vec![work.place(0); drawn.len()],
        values: vec![0.0; drawn.len() * work.sites.mean.len()],
        costs: vec![f32::NAN; drawn.len()],
    };
    for (v, site) in (0..).zip(drawn) {
        painted.set(v, work.place(site), work.sites, f32::NAN);
    }
    painted
}

/// Fisher and Yates's.
pub(super) fn shuffle(items: &mut [u32], rng: &mut Rng) {
    for i in (1..items.len()).rev() {
        items.swap(i, rng.index(i + 1));
    }
}

fn report(work: &Work, painted: &Painted, window: &Window) -> LevelReport {
    let matched = || painted.costs.iter().filter(|cost| cost.is_finite());
    let total: f64 = matched().map(|cost| f64::from(*cost)).sum();
    LevelReport {
        vertices: work.canvas.normals.len(),
        texel: work.canvas.texel,
        edge_variation: work.canvas.edge_variation,
        sites: work.sites.len(),
        window: 2 * window.own + 1,
        coarse_window: window.coarse.map_or(0, |radius| 2 * radius + 1),
        mean_cost: total / matched().count().max(1) as f64,
        coherent_edges: coherent_edges(work, painted),
    }
}

/// Share of the edges along which the sample goes on: the source at one end is, to less than a texel, where the other
/// end's leads to.
fn coherent_edges(work: &Work, painted: &Painted) -> f64 {
    let sample = work.sites.level;
    let (mut all, mut coherent) = (0usize, 0usize);
    for (triangle, [from, to]) in work.canvas.surface.edges() {
        let corners = work.canvas.surface.corners(triangle);
        let [from, to] = [corners[from] as usize, corners[to] as usize];
        all += 1;
        if let Some(there) = work.continued(painted, from, to) {
            let [expected, found] =
                [&there, &painted.sources[to]].map(|place| sample.surface.position(place));
            coherent += usize::from((expected - found).norm() < sample.texel);
        }
    }
    coherent as f64 / all.max(1) as f64
}
