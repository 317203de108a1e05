#pragma once
// Skins: mesh triangles that bridge a silhouette and were never there. Found two ways (Nyland et al. 1999,
// section 4.4):
//
//   by planarity                                  by reprojection
//
//   disparity                                      A .                 . B
//     |  o o o                                        \  skin        /
//     |        \   <- a jump that neither              \ o=====o   /     B sees farther than the triangle of A:
//     |         \     neighbour's slope explains        o \     \o       where A has a surface, B found empty space
//     |          o o o                                      \   / \ far wall
//     +------------------ x
//
// The paper draws A into B through a z-buffer and repeats until a pass finds no skin, since one skin can hide another.
// Whether B saw through a triangle does not depend on the other triangles, so each is asked by itself: one pass finds
// what the repeated passes converge to, and those hidden behind true surfaces of A are behind B's surface too. The same
// question asked of single samples finds those that float in space that others saw to be empty; asked of guesses of
// range (isGuess) it makes those that another image measured surfaces, and those that others saw through nothing.

#include "scene/image_store.h"
#include "scene/overlap.h"
#include "scene/reprojection.h"

namespace scene {

struct SkinOptions {
    float planarity = 0.03f;      ///< least jump, relative to disparity, that no neighbouring slope explains
    int maxPartners = 16;         ///< images asked whether they saw through
    ComparisonOptions comparison; ///< when two images mean the same surface
};

/// What a partner says of an image's samples: how many it measured too, and through how many it saw.
struct PartnerWord {
    std::uint32_t image = 0; ///< the partner
    std::int64_t agrees = 0, sawThrough = 0;
    /// Where they agree, how far the sample is from the partner's surface, across that: the median, metres;
    /// of a sixteenth of the samples, but for those of which it sees the other side. What is farther apart than
    /// ComparisonOptions allow does not agree. 0 if there are none.
    double apartMetres = 0;
};

struct SkinFigures {
    std::int64_t samples = 0, triangles = 0; ///< surfaces of the image, triangles among them
    std::int64_t planarSkins = 0;            ///< triangles cut because disparity jumps
    std::int64_t seenThrough = 0;            ///< further triangles that another image saw through
    std::int64_t floating = 0;               ///< samples that more images saw through than agreed with
    std::int64_t floatingInside = 0;         ///< those about which all are: of a thing, not of the rim of one
    std::int64_t guesses = 0;                ///< guesses of range that no other image speaks for or against
    std::int64_t confirmed = 0, refuted = 0; ///< guesses that others measured, resp. saw through
    std::vector<PartnerWord> words;          ///< of those asked, none that stand where the image does
};

/// The image's flags with kSkinUpper, kSkinLower set by planarity alone.
Image<std::uint8_t> markPlanarSkins(const DepthImage& image, float planarity, SkinFigures& figures);

/// The flags of image `index` with skins of both kinds and floating samples marked and guesses judged.
Image<std::uint8_t> markSkins(ImageStore& images, std::size_t index, const std::vector<Partner>& partners,
                              const SkinOptions& options, SkinFigures& figures);

} // namespace scene
