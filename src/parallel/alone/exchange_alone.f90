!> Messages of a process alone: there are none.
submodule (qsmpm_exchange) exchange_alone
  implicit none

contains

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
end submodule exchange_alone
