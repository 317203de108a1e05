// What is said of scans that do not agree.

#include "app/scan_agreement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace app {

namespace {

using testing::HasSubstr;
using testing::SizeIs;

/// A photograph, and three scans of two faces each.
const std::vector<ScanFaces> kScans{{"yard", 1, 2}, {"gate", 3, 2}, {"road", 5, 2}};

std::vector<scene::SkinFigures> figures() {
    std::vector<scene::SkinFigures> of(7);
    of[1].words = {{2, 9000, 0, 0.5}, {3, 4000, 5, 0.004}, {5, 100, 40, 0.2}};
    of[2].words = {{0, 9000, 900, 0.5}, {4, 2000, 0, 0.009}, {3, 3000, 0, 0.005}};
    of[3].words = {{1, 5000, 0, 0.005}, {6, 6000, 0, 0.08}};
    of[6].words = {{4, 700, 300, 0.06}};
    return of;
}

TEST(ScanAgreement, IsOfPairsOfScansWithEnoughInCommon) {
    const ScanAgreement agreement = scanAgreement(kScans, figures());
    ASSERT_THAT(agreement.pairs, SizeIs(2)) << "neither faces of one scan, nor photographs, nor what hardly overlaps";
    EXPECT_EQ(agreement.pairs[0].a, 0u);
    EXPECT_EQ(agreement.pairs[0].b, 1u);
    EXPECT_EQ(agreement.pairs[0].samples, 14000);
    EXPECT_DOUBLE_EQ(agreement.pairs[0].apartMetres, 0.005);
    EXPECT_EQ(agreement.pairs[1].a, 1u);
    EXPECT_EQ(agreement.pairs[1].b, 2u);
    EXPECT_DOUBLE_EQ(agreement.pairs[1].apartMetres, 0.08);
    EXPECT_THAT(agreement.losses, SizeIs(0));
    EXPECT_EQ(describe(agreement, kScans).at("pairs").at(1).at("apart_m"), 0.08);
    EXPECT_TRUE(describe(agreement, std::vector<ScanFaces>{kScans[0]}).is_null());
}

TEST(ScanAgreement, WhoIsFarApartIsNamed) {
    const std::vector<std::string> given = remarksOn(scanAgreement(kScans, figures()), kScans, true);
    ASSERT_THAT(given, SizeIs(1));
    EXPECT_THAT(given[0], HasSubstr("'gate' and 'road' show the same surfaces they have them 80 mm apart"));
    EXPECT_THAT(given[0], HasSubstr("--register auto"));
    EXPECT_THAT(remarksOn(scanAgreement(kScans, figures()), kScans, false)[0], HasSubstr("how they were registered"));
    std::vector<scene::SkinFigures> near = figures();
    near[3].words[1].apartMetres = near[6].words[0].apartMetres = 0.02;
    EXPECT_THAT(remarksOn(scanAgreement(kScans, near), kScans, true), SizeIs(0));
}

TEST(ScanAgreement, ThingsThatAreNotDrawnAreSaidToBe) {
    std::vector<scene::SkinFigures> of = figures();
    of[0].floatingInside = 5000; // a photograph: others speak of those
    of[1].floatingInside = 60, of[2].floatingInside = 70, of[6].floatingInside = 400, of[3].floatingInside = 9;
    const ScanAgreement agreement = scanAgreement(kScans, of);
    ASSERT_THAT(agreement.losses, SizeIs(2));
    EXPECT_EQ(agreement.losses[0].scan, 2u);
    EXPECT_EQ(agreement.losses[0].mostlyBy, std::size_t{1});
    EXPECT_EQ(agreement.losses[1].samples, 130);
    EXPECT_EQ(agreement.losses[1].mostlyBy, std::nullopt) << "photographs saw through most of it";
    const std::vector<std::string> remarks = remarksOn(agreement, kScans, true);
    ASSERT_THAT(remarks, SizeIs(2));
    EXPECT_THAT(remarks[1], HasSubstr("'road' (400 samples; through most of it 'gate' saw), 'yard' (130 samples; "
                                      "through most of it photographs saw)"));
    EXPECT_TRUE(describe(agreement, kScans).at("losses").at(1).at("seen_through_by").is_null());
}

} // namespace

} // namespace app
