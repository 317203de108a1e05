#pragma once
// How a photograph is turned against the scan it belongs to. Nyland et al. 1999, section 4.2: camera and laser share
// their centre, so that three angles are unknown; edges of the photograph are laid on edges of range and reflectance.
//
// What we changed: edges have directions (align/edge_pictures.h). The paper's broad kernel with a steep middle is a sum
// of Gaussians of several widths. Instead of a simplex with annealed restarts, all turns within reach are tried on the
// broadest; the best of them, apart from each other, climb level by level. So one knows not only the best turn but also
// its rivals, and that decides whether it is believed:
//
//   rivals      how much less the best other turn scores. Chance puts many turns on the same height.
//   parts       each part of the picture is asked by itself how the turn compares with others about it; where the fit
//   is
//               right nearly all like it best, where a few strong edges met by chance most do not care
//   deviation   how much the turn changes if one part of the picture is left out (the jackknife)

#include "scene/align/edge_pictures.h"

#include <string>

#include <glm/mat3x3.hpp>

namespace scene {

struct ColourToRangeOptions {
    double reachRadians = 0.0628;    ///< turns up to this are tried: 3 degrees and a fifth more
    double mostRivalShare = 0.8;     ///< of the best's score, that the best other turn may have
    double leastScore = 1.5;         ///< of the best, see TurnFound
    double leastAgreeing = 0.6;      ///< share of the picture's parts that must like the turn;
    double leastAgreeingAlone = 0.3; ///< the same where no other turn scores more than mostRivalShareAlone
    double mostRivalShareAlone = 0.55;
    int leastParts = 5;                     ///< so many parts must have edges to say something
    double leastDeviationRadians = 0.00014; ///< of each axis: what edges of a scan leave open, however many there are
    double mostDeviationRadians = 0.0006;   ///< of what is believed, all axes together
};

/// What was found of one photograph.
struct ColourFit {
    glm::dmat3 givenFromFound{1.0}; ///< carries directions of the camera as found into the camera as given
    double turnedRadians = 0;       ///< the angle of that rotation
    glm::dmat3 covariance{0.0};     ///< of a further turn, about the axes of the camera as found; radians squared
    double deviationRadians = 0;    ///< one standard deviation, all three axes together
    double score = 0;               ///< of the best turn; in standard deviations of the scan's edges
    double rivalShare = 1;          ///< the best other turn's score over that
    double agreeing = 0;            ///< share of the picture's parts that like the turn better than others about it
    int parts = 0;                  ///< of the picture that have edges
    int neighbours = 0;             ///< photographs of the same scan that it was laid on, too (align/joint_turns.h)
    bool isFound = false;           ///< no chance: it is this turn and no other, exactly known or not
    bool isSure = false;            ///< found, and known as exactly as asked
    std::string why;                ///< of a fit that is not: half a sentence
};

/// scan: what the scan sees from the camera's place with the camera turned as given, grey for reflectance, wider than
/// the photograph by the reach (widened). photograph: without distortion, with pixels about as large as those of scan.
/// The same result on any number of threads.
ColourFit findTurn(const DepthImage& scan, const Image<Rgb8>& photograph, const Camera& camera,
                   const ColourToRangeOptions& options = {});

/// Whether what was found is believed: isFound, isSure and why.
void judge(ColourFit& fit, const ColourToRangeOptions& options);

/// A camera whose picture holds what the other one sees if it is turned by up to the reach in any direction, with
/// pixels of this size in its middle.
Camera widened(const Camera& camera, double reachRadians, double pixelRadians);

/// Levels of blur for a search: broadest about half a degree, each half of the one before, the last about a pixel.
/// fineEdges: what the last two are made of.
std::vector<EdgeLevel> edgeLevels(const EdgeImage& edges, const EdgeImage& fineEdges, double pixelRadians);

} // namespace scene
