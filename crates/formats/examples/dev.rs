fn main() {
    for a in std::env::args().skip(1) {
        let t = std::time::Instant::now();
        let r = formats::import(a.as_ref(), &formats::Options::default());
        let ms = t.elapsed().as_secs_f64() * 1e3;
        match r {
            Ok(i) => {
                if std::env::var("TEXT").is_ok() {
                    println!("{}", i.text)
                } else {
                    println!("== {a} {ms:.1} ms\n{}", i.report)
                }
            }
            Err(p) => println!("== {a} {ms:.1} ms\nERROR {p}"),
        }
    }
}
