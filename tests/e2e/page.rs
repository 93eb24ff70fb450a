//! A page of ours in a browser, with what a person does to it.

use serde_json::Value;

use crate::browser::Browser;

/// The page with what a person does to it.
pub struct Page<'a>(pub &'a Browser);

impl Page<'_> {
    /// Whether a condition holds within a second: the browser lays out in its own time.
    #[track_caller]
    pub fn holds(&self, condition: &str) {
        for _ in 0..50 {
            if self.0.run(&format!("return Boolean({condition})")) == true {
                return;
            }
            std::thread::sleep(std::time::Duration::from_millis(20));
        }
        panic!("does not hold: {condition}; console: {:?}", self.0.console());
    }

    /// A place in an element, as parts of its width and height, once it is in sight.
    #[track_caller]
    pub fn at(&self, element: &str, [x, y]: [f64; 2]) -> [f64; 2] {
        let script = format!(
            "const e = document.querySelector('{element}'); e.scrollIntoView({{ behavior: 'instant', block: 'center' }}); \
             const r = e.getBoundingClientRect(); return [r.left + r.width * {x}, r.top + r.height * {y}]"
        );
        let place: Vec<f64> = self.0.run(&script).as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        // The page hears of the scrolling with its next frame, and hides what the pointer had brought up.
        self.0.run("return new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))");
        [place[0], place[1]]
    }

    /// Clicks in the middle of an element.
    #[track_caller]
    pub fn click(&self, element: &str) {
        let place = self.at(element, [0.5, 0.5]);
        self.0.point(&[place, place], true);
    }

    /// Chooses of a select.
    #[track_caller]
    pub fn choose(&self, select: &str, value: &str) {
        self.0.run(&format!(
            "const s = document.querySelector('{select}'); s.value = '{value}'; s.dispatchEvent(new Event('change', {{ bubbles: true }}))"
        ));
    }

    /// Nothing sticks out to the side, and nothing was complained about.
    #[track_caller]
    pub fn is_sound(&self) {
        let wide = "[...document.querySelectorAll('body *')].filter(e => e.getBoundingClientRect().right > innerWidth + 1 \
                    && !e.closest('.scroll, nav, pre, code, .stage')).map(e => e.tagName + '#' + e.id + '.' + e.className)";
        let wide = self.0.run(&format!("return {wide}"));
        assert_eq!(wide, Value::Array(vec![]), "these are wider than the window");
        self.holds("document.documentElement.scrollWidth <= document.documentElement.clientWidth");
        let said = self.0.console();
        assert!(said.is_empty(), "on the console: {said:?}");
    }
}
