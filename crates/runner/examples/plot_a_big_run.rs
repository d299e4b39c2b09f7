//! What plots and the report cost at the size of the paper's main experiment: makes a run folder with
//! 150 cells of 30,000 made-up updates, draws every figure of it, makes its report, and prints times,
//! sizes and the largest amount of memory that it took.
//!
//! ```text
//! cargo run --release -p runner --example plot_a_big_run [DIR [SETTINGS INSTANCES UPDATES]]
//! ```
//!
//! Without DIR the folder, of 1 GB, is temporary; a run that's there already is drawn again.

use std::{
    error::Error,
    fs,
    io::{BufWriter, Write},
    path::{Path, PathBuf},
    time::Instant,
};

use figures::{FIGURES, Options};
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};
use reward::Terms;
use runner::{
    catalogue::{Catalogue, RunCell},
    report::Report,
};
use runs::{
    Bullet, Cell, Checkpoint, Extent, Header, Look, NewRun, Precision, Recording, RecordingLayout,
};
use svenja::Morphology;
use xxhash_rust::xxh3::xxh3_64;

const MODEL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/svenja.toml");

/// Of a recording.
const N_FEET: usize = 6;
const N_STEPS: usize = 600;
const N_FRAMES: usize = 5;

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, or: usize| words.get(i).map_or(Ok(or), |word| word.parse());
    let [n_settings, n_instances, n_updates] = [number(1, 5)?, number(2, 30)?, number(3, 30_000)?];
    let temporary = tempfile::tempdir()?;
    let folder = words.first().map_or(temporary.path().join("run"), PathBuf::from);
    if !folder.exists() {
        make(&folder, [n_settings, n_instances, n_updates])?;
    }

    let start = Instant::now();
    let catalogue = Catalogue::open(&folder)?;
    let (results, omitted) = catalogue.results(None, &|_, _| {})?;
    omitted.iter().for_each(|it| println!("{it}"));
    println!("{:6.2} s  read", start.elapsed().as_secs_f64());
    let begin = Instant::now();
    let cells = Catalogue::open(&folder)?.status(Look::Quick);
    println!("{:6.2} s  status of {} cells", begin.elapsed().as_secs_f64(), cells.len());
    let out = folder.join("plots");
    fs::create_dir_all(&out)?;
    for figure in &FIGURES {
        let begin = Instant::now();
        let drawing = figures::draw(&results, figure, &Options::default())?;
        let tables = figure.tables(&results);
        let drawn = begin.elapsed().as_secs_f64();
        let png = drawing.png()?;
        println!(
            "{drawn:6.2} s  {}, {} kB; as PNG in {:.2} s, {} kB",
            figure.name,
            drawing.svg.len() / 1000,
            begin.elapsed().as_secs_f64() - drawn,
            png.len() / 1000
        );
        fs::write(out.join(format!("{}.svg", drawing.file_stem)), &drawing.svg)?;
        fs::write(out.join(format!("{}.png", drawing.file_stem)), &png)?;
        for table in tables {
            fs::write(out.join(format!("{}.csv", table.name)), table.csv())?;
        }
    }
    let begin = Instant::now();
    let report = Report::read(std::slice::from_ref(&folder), &|_, _, _| {})?;
    let page = report.html(&|_, _, _| {})?;
    fs::write(folder.join("report.html"), &page)?;
    let seconds = begin.elapsed().as_secs_f64();
    println!("{seconds:6.2} s  report, {:.1} MB", page.len() as f64 / 1e6);
    println!("{:6.2} s  in all, {}", start.elapsed().as_secs_f64(), peak_memory());
    Ok(())
}

/// The most that this process had in memory, as Linux tells it.
fn peak_memory() -> String {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.map_or("memory unknown".into(), |line| format!("{} at most", line.trim()))
}

fn make(
    folder: &Path,
    [n_settings, n_instances, n_updates]: [usize; 3],
) -> Result<(), Box<dyn Error>> {
    let xi = |i: usize| {
        let xi = i as f64 / (n_settings - 1).max(1) as f64;
        (xi * 1000.0).round() / 1000.0
    };
    let swept: Vec<_> = (0..n_settings).map(xi).collect();
    let experiment = format!(
        "model = \"models/svenja.toml\"\n[learning]\nupdates = {n_updates}\n\
         [sweep]\n\"reward.mix.xi\" = {swept:?}\nseeds = {n_instances}\n"
    );
    let morphology = Morphology::open(MODEL.as_ref())?;
    let cells = (0..n_settings * n_instances).map(|index| Cell {
        index,
        setting: format!("xi={}", xi(index / n_instances)),
        seed: (index % n_instances) as u64 + 1,
    });
    let new = NewRun {
        experiment,
        itarl: env!("CARGO_PKG_VERSION").into(),
        bullet: Bullet { version: 325, precision: Precision::Single },
        models: vec![("svenja.toml".into(), fs::read(MODEL)?)],
        policies: Vec::new(),
        seeds: (1..=n_instances as u64).collect(),
        cells: cells.collect(),
    };
    let catalogue = Catalogue::of(runs::Run::create(folder, &new)?)?;
    for RunCell { cell, folder, identity, .. } in catalogue.cells() {
        fs::create_dir_all(folder.path())?;
        let mut random = ChaCha8Rng::seed_from_u64(cell.index as u64);
        let xi = xi(cell.index / n_instances);
        write_metrics(&folder.metrics(), n_updates, xi, &mut random)?;
        let recording = recording(xi, &morphology, &mut random);
        checkpoint(&folder.metrics(), *identity, n_updates as u64, recording.section()?)?
            .write(&folder.checkpoint())?;
        fs::write(folder.replay(), recording.encode()?)?;
    }
    Ok(())
}

/// One as a reader needs it: nothing goes on from it.
fn checkpoint(
    metrics: &Path,
    identity: u64,
    updates: u64,
    recording: Vec<u8>,
) -> std::io::Result<Checkpoint> {
    let rows = fs::read(metrics)?;
    let metrics = Extent { length: rows.len() as u64, xxh3: xxh3_64(&rows) };
    let header = Header { identity, updates, control_steps: 100 * updates, metrics };
    Ok(Checkpoint { header, sections: [("recording".to_string(), recording)].into() })
}

/// Uniform in 0 to 1.
fn uniform(random: &mut ChaCha8Rng) -> f64 {
    random.next_u64() as f64 / u64::MAX as f64
}

/// Learning as the paper describes it: the best mix reaches most; with the task alone more than half
/// get stuck, and some lose what they had.
fn write_metrics(
    path: &Path,
    n_updates: usize,
    xi: f64,
    random: &mut ChaCha8Rng,
) -> std::io::Result<()> {
    let mut out = BufWriter::new(fs::File::create(path)?);
    out.write_all(runs::header_line().as_bytes())?;
    let is_stuck = xi > 0.9 && uniform(random) < 0.55;
    let height = match is_stuck {
        true => 0.004 * uniform(random),
        false => (0.09 * (1.0 - 3.0 * (xi - 0.75).powi(2)) - 0.03 * uniform(random)).max(0.002),
    };
    let middle = (0.15 + 0.5 * uniform(random) + 0.3 * (0.75 - xi).abs()) * n_updates as f64;
    let drop = (xi > 0.9 && uniform(random) < 0.4).then_some(0.8 * n_updates as f64);
    for update in 1..=n_updates {
        let t = update as f64;
        let learned = 1.0 / (1.0 + (-(t - middle) / (0.06 * n_updates as f64)).exp());
        let kept = if drop.is_some_and(|drop| t > drop) { 0.15 } else { 1.0 };
        let noise = |random: &mut ChaCha8Rng| uniform(random) - 0.5;
        let loc = -0.005 + (height + 0.005) * learned * kept + 0.008 * noise(random);
        let nats = 0.02 + 0.2 * (1.0 - xi) + 0.9 * loc.max(0.0) + 0.02 * noise(random);
        let mi = 0.1 * nats / std::f64::consts::LN_2;
        let r = loc.signum() * 100.0 * (loc.abs().powf(xi) * mi.powf(1.0 - xi)).powi(2);
        writeln!(
            out,
            "{update},{},{r:?},{nats:?},{:?},{mi:?},{loc:?},{loc:?},0.0,{xi:?},{:?},{:?},0,0,{:?},{:?},{loc:?}",
            update * 100,
            nats - 0.005,
            loc.abs() * 100.0,
            noise(random),
            1.0 + t.sqrt() * 0.1 + 0.001 * noise(random),
            0.01 + 0.001 * noise(random)
        )?;
    }
    out.flush()
}

/// Feet that step in two groups of three, with some noise.
fn recording(xi: f64, morphology: &Morphology, random: &mut ChaCha8Rng) -> Recording {
    let names = |body: &svenja::Body| body.name.clone();
    let bodies: Vec<String> = morphology.bodies().iter().map(names).collect();
    let feet = morphology.feet().iter().map(|&foot| bodies[foot].clone()).collect();
    let period = 5.0 + 6.0 * uniform(random);
    let touches = |step: usize, foot: usize, random: &mut ChaCha8Rng| {
        let phase = step as f64 / period + if matches!(foot, 0 | 3 | 4) { 0.5 } else { 0.0 };
        let is_down = phase.fract() < 0.6;
        is_down != (uniform(random) < 0.05 + 0.3 * (0.75 - xi).abs())
    };
    let n_bodies = bodies.len();
    // All of it slides forward.
    let frame = |frame: usize| {
        morphology.bodies().iter().flat_map(move |body| {
            let at = body.pose.translation.vector.cast::<f32>();
            [at.x, at.y + 0.01 * frame as f32, at.z, 0.0, 0.0, 0.0, 1.0]
        })
    };
    let mut sensors = Vec::new();
    for step in 0..N_STEPS {
        for foot in 0..N_FEET {
            sensors.push(f32::from(u8::from(touches(step, foot, random))));
        }
    }
    Recording {
        layout: RecordingLayout {
            actuators: Vec::new(),
            bodies,
            frames_per_step: N_FRAMES,
            seconds_per_frame: 0.1 / N_FRAMES as f64,
            sensors: feet,
            terms: Terms::NAMES.map(str::to_owned).into(),
        },
        first_control_step: 0,
        n_steps: N_STEPS,
        poses: (0..N_STEPS * N_FRAMES).flat_map(frame).collect(),
        sensors,
        actions: Vec::new(),
        contacts: vec![0; N_STEPS * n_bodies],
        terms: vec![0.01; N_STEPS * Terms::NAMES.len()],
    }
}
