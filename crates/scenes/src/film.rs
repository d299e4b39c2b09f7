//! Films: a camera that follows the robot, frame by frame, as GIF or through ffmpeg as MP4.

use std::{
    fs::Permissions,
    io::Write,
    os::unix::fs::PermissionsExt,
    path::Path,
    process::{Command, Stdio},
    thread,
};

use nalgebra::{Point3, Vector3};
use svenja::Collider;

use super::{
    Clip, Error,
    render::{Camera, Ground, Ink, Picture, SKY, Scene, Solid},
};

/// What lights up on contact: the viewer's colours.
const CONTACT: [u8; 3] = [0x39, 0xb8, 0xf0];
const PENALISED: [u8; 3] = [0xe8, 0x50, 0x8f];
const PATH: Ink = Ink { colour: [0xd5, 0x5e, 0x00], strength: 1.0 };
const WORDS: Ink = Ink { colour: [0x22, 0x25, 0x2a], strength: 1.0 };

/// From the robot to the camera.
const VIEW: [f64; 3] = [0.8, 0.8, 0.62];
/// From bottom to top of a picture.
const ANGLE_DEGREES: f64 = 34.0;
/// Of the camera's distance, for each metre that the robot reaches from its centre.
const DISTANCE: f64 = 2.95;

/// Pixels of pictures that wait for their turn at most.
const WAITING_PIXELS: usize = 64_000_000;

/// Frames a second. GIF counts in hundredths of a second.
pub const GIF_HZ: f64 = 12.5;
/// Frames a second.
pub const MP4_HZ: f64 = 25.0;

/// A clip's end as pictures in a row.
#[derive(Clone, Debug)]
pub struct Film<'a> {
    clip: &'a Clip,
    size: [usize; 2],
    /// Frames of the clip.
    frames: Vec<usize>,
    hz: f64,
    reach_m: f64,
    /// Centre of gravity of each of the clip's frames.
    path: Vec<Point3<f64>>,
}

impl<'a> Film<'a> {
    /// The last so many simulated seconds, at real speed.
    #[must_use]
    pub fn new(clip: &'a Clip, size: [usize; 2], seconds: f64, hz: f64) -> Self {
        let end = clip.seconds(clip.n_frames() - 1);
        let n = ((seconds.min(end - clip.seconds(0)) * hz).floor() as usize).max(1);
        let frames = (0..n).map(|i| clip.frame_at(end - (n - 1 - i) as f64 / hz)).collect();
        let path = (0..clip.n_frames()).map(|frame| clip.centre_of_gravity(frame)).collect();
        Self { clip, size, frames, hz, reach_m: clip.reach_m(), path }
    }

    /// The number of pictures.
    #[must_use]
    pub fn n_pictures(&self) -> usize {
        self.frames.len()
    }

    /// One of them.
    ///
    /// # Errors
    /// None in practice: see [`Picture::write`].
    pub fn picture(&self, i: usize) -> Result<Picture, Error> {
        let frame = self.frames[i];
        let centre = self.path[frame];
        let view = Vector3::from(VIEW).normalize();
        // At the height that it began with: it may bounce, and the camera doesn't.
        let target = Point3::new(centre.x, centre.y, 0.5 * self.path[0].z);
        let narrow = (self.size[0] as f64 / self.size[1] as f64 / 1.3).min(1.0);
        let eye = target + view * (DISTANCE * self.reach_m / narrow);
        let camera = Camera::perspective(eye, target, ANGLE_DEGREES, self.size);
        let scene = self.scene(frame, &view)?;
        // By one thread: others are at other pictures.
        let mut picture = scene.picture_by(&camera, 1);
        self.draw_path(&mut picture, &scene, &camera, frame);
        let step = frame / self.clip.recording().layout.frames_per_step;
        let step = self.clip.recording().first_control_step + step as u64 + 1;
        let size = (self.size[1] as f32 / 22.0).max(11.0);
        let text = format!("{:.1} s   control step {step}", self.clip.seconds(frame));
        picture.write(&text, [0.6 * size, 1.4 * size], size, WORDS)?;
        Ok(picture)
    }

    fn scene(&self, frame: usize, view: &Vector3<f64>) -> Result<Scene, Error> {
        let morphology = self.clip.morphology();
        let bodies = morphology.bodies().iter().enumerate();
        let solids = bodies.flat_map(|(i, body)| {
            let (colour, glow) = match self.clip.touches(frame, i) {
                true if morphology.penalised().contains(&i) => (PENALISED, 0.3),
                true => (CONTACT, 0.3),
                false => (body.colour, 0.0),
            };
            let pose = self.clip.pose(frame, i);
            let solid = move |it: &Collider| Solid::new(&it.shape, &(pose * it.pose), colour, glow);
            body.colliders.iter().map(solid)
        });
        let solids = solids.collect();
        let centre = self.path[frame];
        // The rows keep their place as long as the robot doesn't leave its stretch.
        let stretch = if self.reach_m < 1.5 { 0.4 } else { 2.0 };
        let away = self.reach_m + 0.7 * stretch;
        let row = |value: f64, side: f64| {
            stretch * (value / stretch).round() + (away / stretch).ceil() * stretch * side.signum()
        };
        let rows = [row(centre.x, -view.x), row(centre.y, -view.y)];
        let ground = Ground::new([centre.x, centre.y], 2.5 * self.reach_m, rows, [view.x, view.y])?;
        Ok(Scene { solids, ground: Some(ground), sky: SKY })
    }

    /// What the centre of gravity has done so far, on the ground below it.
    fn draw_path(&self, picture: &mut Picture, scene: &Scene, camera: &Camera, frame: usize) {
        let below = |point: &Point3<f64>| Point3::new(point.x, point.y, 0.0);
        let width = (self.size[1] as f32 / 160.0).max(1.5);
        let places: Vec<_> =
            self.path[..=frame].iter().map(|point| scene.see(camera, below(point))).collect();
        for pair in places.windows(2) {
            if let [Some(from), Some(to)] = pair {
                picture.line(*from, *to, width, PATH);
            }
        }
        if let Some(Some(here)) = places.last() {
            picture.line(*here, *here, 4.0 * width, PATH);
        }
    }

    /// Makes something of each picture, by all cores, and takes it in their order, until it's told to stop.
    fn in_order<T: Send>(
        &self,
        make: impl Fn(usize) -> Result<T, Error> + Sync,
        mut take: impl FnMut(usize, T) -> Result<bool, Error>,
    ) -> Result<(), Error> {
        let n_threads = thread::available_parallelism().map_or(1, usize::from);
        let most = WAITING_PIXELS / (self.size[0] * self.size[1]).max(1);
        let indices: Vec<_> = (0..self.n_pictures()).collect();
        for some in indices.chunks((4 * n_threads).min(most).max(1)) {
            let made = runs::parallel::map(some, |&i| make(i));
            for (&i, made) in some.iter().zip(made) {
                if !take(i, made?)? {
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// The bytes of a GIF file that plays for ever. `progress` is told how many pictures are done.
    ///
    /// # Errors
    /// None in practice: what the format can't hold.
    pub fn gif(&self, progress: impl Fn(usize)) -> Result<Vec<u8>, Error> {
        let too_large = |_| Error::TooLarge("a GIF can't have more than 65,535 pixels a side");
        let [width, height] = self.size.map(|side| u16::try_from(side).map_err(too_large));
        let (width, height) = (width?, height?);
        let mut bytes = Vec::new();
        let mut encoder = gif::Encoder::new(&mut bytes, width, height, &[])?;
        encoder.set_repeat(gif::Repeat::Infinite)?;
        let frame = |i: usize| {
            let picture = self.picture(i)?;
            let mut frame = gif::Frame::from_rgb_speed(width, height, picture.bytes(), 20);
            frame.delay = (100.0 / self.hz).round() as u16;
            Ok(frame)
        };
        self.in_order(frame, |i, frame| {
            encoder.write_frame(&frame)?;
            progress(i + 1);
            Ok(true)
        })?;
        drop(encoder);
        Ok(bytes)
    }

    /// Writes an MP4 file (H.264) by ffmpeg: under another name first.
    ///
    /// # Errors
    /// If ffmpeg isn't there or fails, with what it said.
    pub fn mp4(&self, path: &Path, progress: impl Fn(usize)) -> Result<(), Error> {
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".").suffix(".mp4").permissions(Permissions::from_mode(0o666));
        let unwritten = |cause| Error::Io { path: path.into(), cause };
        let temporary = builder.tempfile_in(folder).map_err(unwritten)?;
        let mut ffmpeg = self.ffmpeg(temporary.path())?;
        let mut input = ffmpeg.stdin.take();
        let mut broken = false;
        self.in_order(
            |i| self.picture(i),
            |i, picture| {
                // If it has ended early, it says why.
                broken = input.as_mut().is_none_or(|it| it.write_all(picture.bytes()).is_err());
                progress(i + 1);
                Ok(!broken)
            },
        )?;
        drop(input);
        let ended = ffmpeg.wait_with_output().map_err(unwritten)?;
        if broken || !ended.status.success() {
            let said = String::from_utf8_lossy(&ended.stderr).trim().into();
            return Err(Error::Ffmpeg { path: path.into(), how: ended.status.to_string(), said });
        }
        temporary.persist(path).map_err(|error| unwritten(error.error))?;
        Ok(())
    }

    fn ffmpeg(&self, path: &Path) -> Result<std::process::Child, Error> {
        let [width, height] = self.size;
        // H.264 in its most common form wants even sides.
        let even = format!("pad={}:{}", width.next_multiple_of(2), height.next_multiple_of(2));
        let command = Command::new("ffmpeg")
            .args(["-v", "error", "-y", "-f", "rawvideo", "-pixel_format", "rgb24"])
            .args(["-video_size", &format!("{width}x{height}"), "-framerate", &self.hz.to_string()])
            .args(["-i", "-", "-vf", &even, "-pix_fmt", "yuv420p", "-movflags", "+faststart"])
            .args(["-fflags", "+bitexact", "-flags:v", "+bitexact"])
            .arg(path)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn();
        command.map_err(|cause| Error::NoFfmpeg { cause })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::clip;

    #[test]
    fn a_film_ends_where_the_clip_ends() {
        // 60 frames of 0.05 s.
        let clip = clip(30);
        let film = Film::new(&clip, [64, 48], 1.0, 10.0);
        assert_eq!(film.frames, [41, 43, 45, 47, 49, 51, 53, 55, 57, 59]);
        assert_eq!(Film::new(&clip, [64, 48], 100.0, 20.0).n_pictures(), 59);
        assert_eq!(Film::new(&clip, [64, 48], 0.01, 10.0).frames, [59]);
    }

    #[test]
    fn a_gif_has_all_pictures_and_the_robot_moves_in_them() {
        let clip = clip(8);
        let film = Film::new(&clip, [96, 64], 0.4, 12.5);
        let bytes = film.gif(|_| ()).unwrap();
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(bytes.as_slice()).unwrap();
        assert_eq!((decoder.width(), decoder.height()), (96, 64));
        let mut pictures = Vec::new();
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            assert_eq!((frame.delay, frame.width, frame.height), (8, 96, 64));
            pictures.push(frame.buffer.to_vec());
        }
        assert_eq!(pictures.len(), film.n_pictures());
        assert_eq!(pictures.len(), 5);
        for pair in pictures.windows(2) {
            let changed = pair[0].chunks(4).zip(pair[1].chunks(4)).filter(|(a, b)| a != b).count();
            assert!(changed > 60, "{changed} of {}", 96 * 64);
        }
        assert_eq!(bytes, film.gif(|_| ()).unwrap());
    }

    /// The ball touches in odd steps: then there's blue, and else there's none.
    #[test]
    fn what_touches_lights_up() {
        let clip = clip(4);
        let blue = |frame: usize| {
            let mut film = Film::new(&clip, [96, 64], 1.0, 20.0);
            film.frames = vec![frame];
            let picture = film.picture(0).unwrap();
            let is_blue = |it: &&[u8; 3]| it[2] > 120 && it[0] < it[2] / 2;
            picture.pixels().iter().filter(is_blue).count()
        };
        assert_eq!((blue(0), blue(4)), (0, 0));
        assert!(blue(2) > 10 && blue(7) > 10, "{} {}", blue(2), blue(7));
    }
}
