//! Formulas are found in sentences and set; words, units and names are left alone.

use super::prose;

/// The formulas of a text, without tags.
fn formulas(text: &str) -> Vec<String> {
    let html = prose(text);
    let bare = |part: &str| {
        let inside = part.split("</math>").next().unwrap_or_default();
        let texts = inside.split('<').filter_map(|tag| tag.split_once('>'));
        texts.map(|(_, text)| text).collect::<String>()
    };
    html.split("<math>").skip(1).map(bare).collect()
}

#[test]
fn formulas_of_sentences_are_found() {
    for (text, expected) in [
        (
            "Where do the eigenvalues of M⁻¹𝒜 lie for each C?",
            vec!["M−1𝒜"],
        ),
        ("onto S_u = A + B C⁻¹Bᵀ, which", vec!["Su=A+BC−1BT"]),
        (
            "with H = 0 and C = BᵀA⁻¹B, 1 (n_u times) and ½ (n_t times).",
            vec!["H=0", "C=BTA−1B", "nu", "nt"],
        ),
        ("the disc |λ − ½| ≤ ½ (derived)", vec!["|λ−½|≤½"]),
        ("they are eig(S + H, S + C): below", vec!["eig(S+H,S+C)"]),
        (
            "λ₁λ₂ = (1 − γh/c)² (s + h)/(s + c) (derived)",
            vec!["λ1λ2=(1−γh/c)2(s+h)/(s+c)"],
        ),
        ("φ = 10 deg: every face", vec!["φ=10"]),
        ("γ = ‖B‖²/‖A‖ and s", vec!["γ=‖B‖2/‖A‖"]),
        ("errors `‖u − u_ref‖/‖u_ref‖` of", vec!["‖u−uref‖/‖uref‖"]),
        ("α_u, β_u, α_t by Lanczos", vec!["αu", "βu", "αt"]),
        ("κ(S_u) finite", vec!["κ(Su)"]),
        ("around S̃_u⁻¹ in f32", vec!["S~u−1"]),
        ("tolerance τ ≤ 2.5e-3 here", vec!["τ≤2.5×10−3"]),
        ("Exact S_u: real; b_i = sin i, too", vec!["Su", "bi=sini"]),
        (
            "ρ = tr H_ff / tr (Bᵀ diag(A)⁻¹ B)_ff (fitted_h).",
            vec!["ρ=trHff/tr(BTdiag(A)−1B)ff"],
        ),
        ("with √(1 − ρ) beside", vec!["1−ρ"]),
    ] {
        assert_eq!(formulas(text), expected, "{text}: {}", prose(text));
    }
}

#[test]
fn words_units_and_names_are_none() {
    for text in [
        "A body of 25 × 24 × 24 m with 4 m³ and 1e-14 m³, 10⁻⁴ to 10⁴.",
        "I took C as it is; A, B, C.",
        "the choices local_h and e08_size of `analogue_b`",
        "GMRES(100), RACP and MCP+AMG: 17, 61, 89",
        "`--inner amg` or `mesh.x.cells = 8` in `scene.toml`",
        "a – b … c/d and and/or",
        "lengths in µm, kg/m³ and N/m²",
        "",
        "C = H-blind choices",
    ] {
        assert!(formulas(text).is_empty(), "{text}: {}", prose(text));
    }
}

#[test]
fn indices_and_powers_hang_on_what_they_belong_to() {
    assert_eq!(
        prose("S_u⁻¹"),
        "<math><msubsup><mi>S</mi><mrow><mi>u</mi></mrow><mrow><mo>−</mo><mn>1</mn></mrow></msubsup></math>"
    );
    assert_eq!(
        prose("a <b> & n_t < 2"),
        "a &lt;b&gt; &amp; <math><msub><mi>n</mi><mrow><mi>t</mi></mrow></msub><mo>&lt;</mo><mn>2</mn></math>"
    );
}

#[test]
fn whatever_is_written_the_page_stays_well_formed() {
    let words = [
        "S_u",
        "(",
        ")",
        "=",
        "M⁻¹𝒜",
        "[λ",
        "‖x‖",
        "√",
        "√(",
        "_",
        "^",
        "^{",
        "word",
        "<b>",
        "λ_",
        "⁻¹",
        "A",
        "1e-",
        "|",
        "~",
    ];
    let mut seed = 1u64;
    for _ in 0..20_000 {
        let mut text = String::new();
        for _ in 0..6 {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            text += words[(seed >> 33) as usize % words.len()];
            if seed >> 63 == 0 {
                text.push(' ');
            }
        }
        let html = prose(&text);
        let mut open = Vec::new();
        for tag in html.split('<').skip(1) {
            let name = tag.split(['>', ' ']).next().unwrap_or_default();
            if tag.contains("/>") {
                continue;
            }
            match name.strip_prefix('/') {
                Some(name) => assert_eq!(open.pop(), Some(name), "{text}: {html}"),
                None => open.push(name),
            }
        }
        assert!(open.is_empty(), "{text}: {html}");
    }
}
