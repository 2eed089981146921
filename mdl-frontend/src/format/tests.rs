use super::*;

/// Formats the body of a module, and checks that nothing is left to do.
fn formatted(text: &str) -> String {
    let text = format!("mdl 1.9;\n{text}");
    let once = format(&text, "test").unwrap_or_else(|errors| panic!("{errors:?}\n{text}"));
    assert!(same_content(&text, &once), "tokens were lost in\n{once}");
    assert_eq!(format(&once, "test").as_deref(), Ok(&*once), "formatting again changes something");
    once.strip_prefix("mdl 1.9;\n").unwrap_or(&once).to_string()
}

#[track_caller]
fn check(text: &str, expected: &str) {
    assert_eq!(formatted(text), expected);
}

#[test]
fn blanks_are_normal() {
    check(
        "import  ::df :: * ,a::b,. :: c::*,.. :: .. ::d::* ;using ::c import x,y;float f( float x=1.0 ){return -x+ - -x*2.0-(x);}",
        "import ::df::*, a::b, .::c::*, ..::..::d::*;\nusing ::c import x, y;\n\
         float f(float x = 1.0) {\n    return -x + - -x * 2.0 - (x);\n}\n",
    );
    check("int f(int i)=i ++ + ++ i- -- i;", "int f(int i) = i++ + ++i - --i;\n");
    check("int f(int a)=a<1?a :a>2? b:c;", "int f(int a) = a < 1 ? a : a > 2 ? b : c;\n");
    check(
        "int f()=operator + (x:1 ,y : operator[ ](a,1))+cast < int [2] > (x)[ a[1] ];",
        "int f() = operator+(x: 1, y: operator[](a, 1)) + cast<int[2]>(x)[a[1]];\n",
    );
    check("float f(float [ < N > ] a)=a [0].x ;", "float f(float[<N>] a) = a[0].x;\n");
    check("float f() [[ ] ] = a[b[0] ];", "float f() [[]] = a[b[0]];\n");
    check("float f(float x [[ a(b[1] ) ] ] , int i) = 1;", "float f(float x [[ a(b[1]) ]], int i) = 1;\n");
    check("material m( * )=base ( ) ;", "material m(*) = base();\n");
    check("bool f()=! a&&~ b==0;", "bool f() = !a && ~b == 0;\n");
}

#[test]
fn blocks_are_indented() {
    check(
        "int f(int x){if(x>1){x=1;}else if(x<0)return 2;else{x=3;}while(x>0){--x;}do{x+=1;}while(x<9);\
         for(int i=0,j=1;i<3;++i,--j){x+=i;}for(;;)break;switch(x){case 0:case 1:x=2;break;default:x=3;}return x;}",
        "int f(int x) {\n    if (x > 1) {\n        x = 1;\n    } else if (x < 0) return 2;\n    else {\n        x = 3;\n    }\n    \
         while (x > 0) {\n        --x;\n    }\n    do {\n        x += 1;\n    } while (x < 9);\n    \
         for (int i = 0, j = 1; i < 3; ++i, --j) {\n        x += i;\n    }\n    for (;;) break;\n    \
         switch (x) {\n        case 0:\n        case 1:\n            x = 2;\n            break;\n        \
         default:\n            x = 3;\n    }\n    return x;\n}\n",
    );
    check("struct s{float a=1.0;int b;};", "struct s {\n    float a = 1.0;\n    int b;\n};\n");
    check("enum e{a=1,b,c};", "enum e { a = 1, b, c };\n");
    check(
        "material m()=let{float a=1.0;}in material(thin_walled:true);",
        "material m() = let {\n    float a = 1.0;\n} in material(thin_walled: true);\n",
    );
    check("float f(){}", "float f() {}\n");
}

#[test]
fn long_lists_are_broken() {
    check(
        "export material m(color first_parameter=color(1.0)[[anno::display_name(\"first\")]],float second_parameter=0.5)=material();",
        "export material m(\n    color first_parameter = color(1.0) [[ anno::display_name(\"first\") ]],\n    \
         float second_parameter = 0.5\n) = material();\n",
    );
    let sum = vec!["some_name"; 14].join("+");
    check(
        &format!("int f()={sum};"),
        "int f() = some_name + some_name + some_name + some_name + some_name + some_name + some_name\n    \
         + some_name + some_name + some_name + some_name + some_name + some_name + some_name;\n",
    );
}

#[test]
fn comments_are_kept() {
    check(
        "// first\n\n\n// second\nfloat f(// a\n float x /* b */, // c\n float y) { // d\n // e\n return x; // f\n // g\n}\n// end",
        "// first\n\n// second\nfloat f( // a\n    float x /* b */, // c\n    float y\n) { // d\n    // e\n    \
         return x; // f\n    // g\n}\n// end\n",
    );
    check("float f() = /* a */ 1.0 /* b */ + 2.0;", "float f() = /* a */ 1.0 /* b */ + 2.0;\n");
}

#[test]
fn empty_lines_are_kept_once() {
    check(
        "const int a = 1;\n\n\n\nconst int b = 2;\nconst int c = 3;",
        "const int a = 1;\n\nconst int b = 2;\nconst int c = 3;\n",
    );
}

#[test]
fn header_and_line_ends_are_normal() {
    let text = "\u{feff}// licence\r\n/* mdl 1.0; */ mdl  1.7 ;\r\nimport ::df::*;\r\n";
    assert_eq!(format(text, "test").as_deref(), Ok("// licence\n/* mdl 1.0; */ mdl 1.7;\nimport ::df::*;\n"));
}

#[test]
fn broken_modules_are_refused() {
    assert_eq!(format("mdl 1.7; float f() = ;", "test").unwrap_err().diagnostics[0].code.0, "E0103");
    // Places are those in the text without its mark.
    let unparsed = format("\u{feff}mdl 1.7; float f() = ;", "test").unwrap_err();
    let span = unparsed.diagnostics[0].place().span;
    assert_eq!(&unparsed.text[span.start as usize..span.end as usize], ";");
}

#[test]
fn every_module_of_the_tests_keeps_its_meaning() {
    let mut folders = vec![std::path::PathBuf::from(env!("CARGO_MANIFEST_DIR"))];
    let mut count = 0;
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("readable") {
            let path = entry.expect("readable").path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            if path.extension().is_none_or(|extension| extension != "mdl") {
                continue;
            }
            let text = std::fs::read_to_string(&path).expect("readable");
            for part in
                text.split_inclusive('\n').collect::<Vec<_>>().split(|line| line.starts_with("//---- "))
            {
                count += u32::from(keeps_its_meaning(&part.concat(), &path));
            }
        }
    }
    assert!(count > 200, "only {count} modules");
}

/// Whether a text is a module without errors; then it must survive.
fn keeps_its_meaning(text: &str, path: &std::path::Path) -> bool {
    let Ok(once) = format(text, "test") else { return false };
    let text = text.trim_start_matches('\u{feff}').replace("\r\n", "\n");
    let printed = printer::print(&layout::layout(&text, &pieces::pieces(&text)));
    assert!(same_content(&text, &printed), "{}: tokens were lost in\n{printed}", path.display());
    assert_eq!(format(&once, "test").as_deref(), Ok(&*once), "{}", path.display());
    true
}

#[test]
fn comments_at_the_end_need_no_line_end() {
    for text in ["mdl 1.7;\n/* a *///b", "mdl 1.7;\n/* a *//* b */", "mdl 1.7; /* a *//* b */"] {
        let once = format(text, "test").expect("it parses");
        assert_eq!(format(&once, "test").as_deref(), Ok(&*once), "{text}");
    }
}

#[test]
fn returns_before_a_line_end_go_together() {
    let once = format("mdl 1.7;\r\r\n/* a\r\r\nb */\r\n", "test").expect("it parses");
    assert_eq!(once, "mdl 1.7;\n/* a\nb */\n");
}

#[test]
fn comments_and_line_ends_anywhere_are_kept() {
    let text = include_str!("../../tests/materials/noise.mdl").to_string()
        + "float more(int i) { switch (i) { case 0: return 1.0; default: break; } do ++i; while (i < 3); \
           if (i > 1) ; else { } return let { float a = 1.0; } in a; } enum e { a, b = 2 }; \
           struct s { float3 x = float3(1.0); };";
    let mut sink = Sink::new("".into());
    let tokens = lexer::lex(&text, &mut sink).tokens;
    let mut random = 0x9E37_79B9_7F4A_7C15u64;
    for _ in 0..400 {
        let mut changed = text.clone();
        for _ in 0..6 {
            random ^= random << 13;
            random ^= random >> 7;
            random ^= random << 17;
            let (_, span) = tokens[(random >> 32) as usize % tokens.len()];
            const PARTS: [&str; 6] = [" /* x */ ", " // x\n", "\n", "\n\n\n", "/* x\n y */", "\n// x\n\n"];
            let part = PARTS[random as usize % PARTS.len()];
            // Positions behind an earlier insertion are wrong, and may break a word; then it is no module.
            let at = (span.start as usize).min(changed.len());
            if changed.is_char_boundary(at) {
                changed.insert_str(at, part);
            }
        }
        keeps_its_meaning(&changed, std::path::Path::new(&changed));
    }
}
