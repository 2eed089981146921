//! Diagnostics of annotations. Most are warnings: a wrong annotation is dropped, and the module compiles.

use super::declare::did_you_mean;

diagnostics! {
    /// An annotation declaration that cannot be.
    E0701 AnnotationParameter { ty: String } "a parameter of an annotation cannot have type `{ty}`";

    /// An annotation that nothing declares. It is dropped.
    W0701 UnknownAnnotation { name: String, similar: Option<String> } "unknown annotation `{name}` is ignored"
        help(did_you_mean(similar));

    /// An annotation whose arguments fit no declaration. It is dropped.
    W0702 WrongAnnotation { name: String, reason: String } "annotation `{name}` is ignored: {reason}";

    /// An annotation argument that is not constant. The annotation is dropped.
    W0703 AnnotationNotConstant { name: String } "annotation `{name}` is ignored: its arguments must be constant";

    /// The bounds of a range are in the wrong order. The range is dropped.
    W0704 EmptyRange { name: String } "`{name}` is ignored: its minimum is above its maximum";

    /// A range of another type than the parameter. The range is dropped.
    W0705 RangeType { name: String, ty: String } "`{name}` is ignored: it does not fit a value of type `{ty}`";

    /// A default lies outside the hard range of its parameter.
    W0706 DefaultOutsideRange { name: String } "the default of `{name}` is outside its hard range";

    /// A soft range reaches outside the hard range.
    W0707 SoftOutsideHard { name: String } "the soft range of `{name}` reaches outside its hard range";

    /// An annotation that may occur once occurs again. The second is dropped.
    W0708 AnnotationTwice { name: String } "second `{name}` is ignored";
}
