# Walk cells.
revisit_test(revisit_plan_tests LABELS unit LINKS scene scene_plan
    SOURCES scene/plan/simplex_test.cpp scene/plan/walk_cells_test.cpp)
revisit_test(revisit_position_search_tests LABELS scenes LINKS scene scene_plan
    SOURCES scene/plan/position_search_test.cpp)
revisit_bench(revisit_plan_bench LINKS scene_plan CGAL::CGAL SOURCES bench/plan_bench.cpp)
