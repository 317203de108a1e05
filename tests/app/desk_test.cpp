#include "app/desk.h"

#include <gtest/gtest.h>

namespace app {

namespace {

TEST(Desk, AStrokeThatWasOverBeforeItWasHeardCounts) {
    Desk desk({});
    input::DeskSays stroke;
    stroke.wants.turn = 1, stroke.picks = true, stroke.wants.undo = true, stroke.wants.turnBy = 0.1;
    desk.say(stroke);
    desk.say({});
    desk.say({});
    const input::DeskSays heard = desk.hear();
    EXPECT_EQ(heard.wants.turn, 1);
    EXPECT_TRUE(heard.picks);
    EXPECT_TRUE(heard.wants.undo);
    EXPECT_EQ(heard.wants.turnBy, 0.1);
    const input::DeskSays after = desk.hear();
    EXPECT_EQ(after.wants.turn, 0);
    EXPECT_FALSE(after.picks || after.wants.undo);
    EXPECT_EQ(after.wants.turnBy, 0);
}

TEST(Desk, WhatIsHeldGoesOnAndWhatIsSaidOnceDoesNot) {
    Desk desk({});
    input::DeskSays held;
    held.wants.move = {0, 1}, held.picks = true, held.wants.next = true, held.wants.speedUp = 1;
    desk.say(held);
    desk.hear();
    const input::DeskSays again = desk.hear();
    EXPECT_EQ(again.wants.move, glm::dvec2(0, 1));
    EXPECT_TRUE(again.picks);
    EXPECT_FALSE(again.wants.next);
    EXPECT_EQ(again.wants.speedUp, 0);
}

TEST(Desk, PicturesAreTakenOnceAndAskedForAnew) {
    Desk desk({});
    EXPECT_TRUE(desk.wantsPicture());
    render::FramePictures pictures;
    EXPECT_FALSE(desk.take(pictures));
    pictures.frame = 5;
    desk.show(pictures);
    EXPECT_FALSE(desk.wantsPicture()) << "one waits already";
    render::FramePictures taken;
    ASSERT_TRUE(desk.take(taken));
    EXPECT_EQ(taken.frame, 5u);
    EXPECT_FALSE(desk.take(taken));
    desk.askForPicture();
    EXPECT_TRUE(desk.wantsPicture());
}

} // namespace

} // namespace app
