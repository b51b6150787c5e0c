!> Team of a single process: values of this process are those of the team.
submodule (qsmpm_team) team_alone
  implicit none

contains

  module procedure start_team
  end procedure start_team

  module procedure end_team
  end procedure end_team

  module procedure team_world
    team = team_type()
  end procedure team_world

  module procedure solo_communicator
    handle = 0
  end procedure solo_communicator

  module procedure total_real
    whole = x
  end procedure total_real

  module procedure total_reals
    wholes = x
  end procedure total_reals

  module procedure total_long
    whole = x
  end procedure total_long

  module procedure total_longs
    wholes = x
  end procedure total_longs

  module procedure largest
    extreme = x
  end procedure largest

  module procedure smallest_real
    extreme = x
  end procedure smallest_real

  module procedure smallest_reals
    extremes = x
  end procedure smallest_reals

  module procedure collect_longs
    rows = mine
    first = [1, size(mine) + 1]
  end procedure collect_longs

  module procedure spread_longs
  end procedure spread_longs

  module procedure hand_over_longs
    theirs = mine
    first_theirs = first
  end procedure hand_over_longs
end submodule team_alone
