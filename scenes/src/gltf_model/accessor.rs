//! Numbers of accessors, whatever their component type, stride and sparse changes.

use gltf::json::accessor::{ComponentType, Type, sparse::Sparse};
use gltf::json::validation::Checked;

use super::document::Source;
use crate::error::SceneError;

/// Most elements of an accessor that has no data behind it, only sparse changes.
const MAX_ELEMENTS_WITHOUT_DATA: u64 = 1 << 24;

/// Bytes of a component.
fn size(kind: ComponentType) -> usize {
    match kind {
        ComponentType::I8 | ComponentType::U8 => 1,
        ComponentType::I16 | ComponentType::U16 => 2,
        ComponentType::U32 | ComponentType::F32 => 4,
    }
}

/// One component as a number; `normalised` integers are fractions.
fn float(kind: ComponentType, normalised: bool, b: &[u8]) -> f32 {
    let (value, most) = match kind {
        ComponentType::I8 => (f32::from(b[0] as i8), 127.0),
        ComponentType::U8 => (f32::from(b[0]), 255.0),
        ComponentType::I16 => (f32::from(i16::from_le_bytes([b[0], b[1]])), 32_767.0),
        ComponentType::U16 => (f32::from(u16::from_le_bytes([b[0], b[1]])), 65_535.0),
        ComponentType::U32 => (u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32, u32::MAX as f32),
        ComponentType::F32 => return f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
    };
    if normalised { (value / most).max(-1.0) } else { value }
}

/// One component of an unsigned whole type.
fn whole(kind: ComponentType, b: &[u8]) -> Option<u32> {
    match kind {
        ComponentType::U8 => Some(u32::from(b[0])),
        ComponentType::U16 => Some(u32::from(u16::from_le_bytes([b[0], b[1]]))),
        ComponentType::U32 => Some(u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        _ => None,
    }
}

/// Where elements lie in the bytes of a view.
struct Span {
    view: usize,
    offset: u64,
    count: u64,
    /// Bytes of an element.
    element: usize,
}

impl Source {
    /// The accessor's elements of `N` components each.
    pub fn floats<const N: usize>(&self, index: usize) -> Result<Vec<[f32; N]>, SceneError> {
        let normalised = self.root().accessors.get(index).is_some_and(|accessor| accessor.normalized);
        self.elements(index, |kind, bytes| Some(float(kind, normalised, bytes)))
    }

    /// The accessor's elements as indices.
    pub fn indices(&self, index: usize) -> Result<Vec<u32>, SceneError> {
        Ok(self.numbers::<1>(index)?.into_iter().map(|[i]| i).collect())
    }

    /// The accessor's elements of `N` whole numbers each.
    pub fn numbers<const N: usize>(&self, index: usize) -> Result<Vec<[u32; N]>, SceneError> {
        self.elements(index, whole)
    }

    fn elements<T: Copy + Default, const N: usize>(
        &self,
        index: usize,
        convert: impl Fn(ComponentType, &[u8]) -> Option<T>,
    ) -> Result<Vec<[T; N]>, SceneError> {
        let name = self.root().accessors.get(index).and_then(|a| a.name.as_deref());
        let part = name.map_or_else(|| format!("accessor {index}"), |name| format!("accessor {index} `{name}`"));
        let broken = |what: String| self.bad(part.clone(), what, "export the model again");
        let accessor = self.root().accessors.get(index).ok_or_else(|| broken("there is no such accessor".into()))?;
        let (Checked::Valid(kind), Checked::Valid(dimensions)) = (accessor.component_type, accessor.type_) else {
            return Err(broken("its type is not valid glTF".into()));
        };
        if components(dimensions) != N || convert(kind.0, &[0; 4]).is_none() {
            let what = format!("its elements are {dimensions:?} of {:?}", kind.0);
            return Err(broken(format!("{what}, and {N} {} needed", if N == 1 { "number is" } else { "numbers are" })));
        }
        let kind = kind.0;
        let element = size(kind) * N;
        let one = |bytes: &[u8]| -> [T; N] {
            std::array::from_fn(|i| convert(kind, &bytes[i * size(kind)..]).unwrap_or_default())
        };
        let count = accessor.count.0;
        let mut list: Vec<[T; N]> = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.map_or(0, |o| o.0);
                let span = Span { view: view.value(), offset, count, element };
                self.slices(&part, &span)?.map(one).collect()
            }
            None if count <= MAX_ELEMENTS_WITHOUT_DATA => vec![[T::default(); N]; count as usize],
            None => return Err(broken(format!("it has {count} elements without data"))),
        };
        if let Some(sparse) = &accessor.sparse {
            self.change(&part, sparse, element, &mut list, one)?;
        }
        Ok(list)
    }

    /// Applies sparse changes.
    fn change<T>(
        &self,
        part: &str,
        sparse: &Sparse,
        element: usize,
        list: &mut [T],
        one: impl Fn(&[u8]) -> T,
    ) -> Result<(), SceneError> {
        let (places, values) = (&sparse.indices, &sparse.values);
        let Checked::Valid(kind) = places.component_type else {
            return Err(self.bad(part, "the type of its sparse indices is not valid glTF", "export the model again"));
        };
        let count = sparse.count.0;
        let at = Span { view: places.buffer_view.value(), offset: places.byte_offset.0, count, element: size(kind.0) };
        let new = Span { view: values.buffer_view.value(), offset: values.byte_offset.0, count, element };
        for (place, value) in self.slices(part, &at)?.zip(self.slices(part, &new)?) {
            let place = whole(kind.0, place).unwrap_or(u32::MAX);
            let length = list.len();
            let slot = list.get_mut(place as usize).ok_or_else(|| {
                self.bad(
                    part,
                    format!("sparse index {place} is beyond its {length} elements"),
                    "export the model again",
                )
            })?;
            *slot = one(value);
        }
        Ok(())
    }

    /// The bytes of each element of a span.
    fn slices<'a>(&'a self, part: &str, span: &Span) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>, SceneError> {
        let bytes = self.view(part, span.view)?;
        let stride = self.root().buffer_views[span.view].byte_stride.map_or(0, |stride| stride.0);
        let (element, count) = (span.element, span.count);
        let stride = if stride == 0 { element } else { stride };
        let needed = count.checked_sub(1).map_or(Some(0), |gaps| {
            gaps.checked_mul(stride as u64)?.checked_add(element as u64)?.checked_add(span.offset)
        });
        if stride < element || needed.is_none_or(|needed| needed > bytes.len() as u64) {
            let what = format!(
                "{count} elements of {element} bytes, {stride} apart, from byte {} of buffer view {} do not fit its {} bytes",
                span.offset,
                span.view,
                bytes.len()
            );
            return Err(self.bad(part, what, "export the model again"));
        }
        let start = span.offset as usize;
        Ok((0..count as usize).map(move |i| &bytes[start + i * stride..][..element]))
    }
}

/// Components of an element.
fn components(dimensions: Type) -> usize {
    match dimensions {
        Type::Scalar => 1,
        Type::Vec2 => 2,
        Type::Vec3 => 3,
        Type::Vec4 | Type::Mat2 => 4,
        Type::Mat3 => 9,
        Type::Mat4 => 16,
    }
}
