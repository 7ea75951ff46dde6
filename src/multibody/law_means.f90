!> Means of a law of one variable between two values of it. They are the force over a step whose work is exact, and the energy of
!> the law. Floor: multibody. Source: doc/theory, eqs. (3.35), (3.36).
module limber_multibody_law_means
   use, intrinsic :: ieee_exceptions, only: ieee_get_halting_mode, ieee_set_halting_mode, ieee_get_flag, ieee_set_flag, &
      & ieee_all
   use limber_base_kinds, only: wp, long
   use limber_deck_expression, only: expression_type
   use limber_deck_operations, only: jet_type
   use limber_deck_range, only: range_type, law_range_over
   use limber_model_model, only: most_slots
   implicit none
   private
   public :: mean_law, find_law_mean

   !> Gauss points and weights on -1..1, how often an interval is halved at most, and how many may be rough: in a step, and of
   !> an energy
   real(wp), parameter :: gauss(5) = [-0.906179845938663993_wp, -0.538469310105683091_wp, 0.0_wp, 0.538469310105683091_wp, &
      & 0.906179845938663993_wp]
   real(wp), parameter :: gauss_weights(5) = [0.236926885056189088_wp, 0.478628670499366468_wp, 0.568888888888888889_wp, &
      & 0.478628670499366468_wp, 0.236926885056189088_wp]
   integer, parameter :: deepest = 40, few_rough = 64, most_rough = 1024

contains

   !> Mean of a law of one variable between two values of it: its antiderivative's difference over theirs, by Gauss's formula on
   !> intervals that are halved until both halves agree with the whole, and the law takes the same branches at both ends: a stop
   !> that begins behind the last of Gauss's points counts too. Kinks leave few intervals rough, however deep; where very
   !> many are, it is the law's own round-off that is seen, and halving ends.
   pure real(wp) function mean_law(law, sign, shift, start, end) result(mean)
      type(expression_type), intent(in) :: law
      !> Each slot is sign times the variable + shift
      real(wp), intent(in) :: sign(:), shift(:)
      real(wp), intent(in) :: start, end
      real(wp) :: open
      call find_law_mean(law, sign, shift, start, end, .false., mean, open)
   end function mean_law

   !> The same, and how much of it, in size, comes from the intervals that were not small enough at last. Over a long way, as that
   !> of an energy, all points of an interval may miss what comes and goes between them: its bounds do not. It is halved as long as
   !> they lie beyond the points by as much as in its parent; bounds that are only wide shrink.
   pure subroutine find_law_mean(law, sign, shift, start, end, is_long, mean, open, doubt)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: sign(:), shift(:)
      real(wp), intent(in) :: start, end
      !> Whether the way may be long
      logical, intent(in) :: is_long
      real(wp), intent(out) :: mean, open
      !> By how much halves and whole of such intervals differ
      real(wp), intent(out), optional :: doubt
      !> Errors relative to the largest value that count as round-off, and where very many intervals are rough; excess of bounds
      !> that counts as none; part of it that is left in a half where bounds are only wide
      real(wp), parameter :: fine = 1.0e-15_wp, coarse = 1.0e-11_wp, negligible = 1.0e-13_wp, shrinks = 0.6_wp
      !> Ends of the intervals that are rough, branches there, means over them, and the least and largest value at their points
      real(wp) :: ends(2, most_rough), means(most_rough), spans(2, most_rough)
      real(wp) :: next_ends(2, 2*most_rough), next_means(2*most_rough), next_spans(2, 2*most_rough)
      integer(long) :: branches(2, most_rough), next_branches(2, 2*most_rough), between
      real(wp) :: middle, halves(2), values(2, 2), level, share, exact, differences
      integer :: i, rough, found, depth, most
      logical :: differs, hides, bounded
      mean = 0.0_wp
      open = 0.0_wp
      level = 0.0_wp
      share = 1.0_wp
      exact = fine
      rough = 1
      between = -1
      bounded = is_long .and. law%may_bend()
      most = merge(most_rough, few_rough, is_long)
      hides = .false.
      ends(:, 1) = [start, end]
      branches(1, 1) = branch_at(law, sign, shift, start, end - start)
      branches(2, 1) = branches(1, 1)
      if (branches(1, 1) >= 0) branches(2, 1) = branch_at(law, sign, shift, end, end - start)
      call gauss_mean(law, sign, shift, ends(:, 1), means(1), spans(:, 1), level)
      do depth = 1, deepest
         found = 0
         open = 0.0_wp
         differences = 0.0_wp
         do i = 1, rough
            middle = ends(1, i) + 0.5_wp*(ends(2, i) - ends(1, i))
            call gauss_mean(law, sign, shift, [ends(1, i), middle], halves(1), values(:, 1), level)
            call gauss_mean(law, sign, shift, [middle, ends(2, i)], halves(2), values(:, 2), level)
            if (branches(1, 1) >= 0) between = branch_at(law, sign, shift, middle, end - start)
            differs = share*abs(0.5_wp*sum(halves) - means(i)) > exact*level .or. any(branches(:, i) /= between)
            if (bounded .and. .not. differs) hides = may_hide(ends(:, i), spans(:, i), middle, values, share)
            if (differs .or. hides) then
               next_ends(:, found + 1) = [ends(1, i), middle]
               next_ends(:, found + 2) = [middle, ends(2, i)]
               next_branches(:, found + 1) = [branches(1, i), between]
               next_branches(:, found + 2) = [between, branches(2, i)]
               next_means(found + 1:found + 2) = halves
               next_spans(:, found + 1:found + 2) = values
               found = found + 2
               if (differs) open = open + 0.5_wp*share*sum(abs(halves))
               differences = differences + share*abs(0.5_wp*sum(halves) - means(i))
            else
               mean = mean + 0.5_wp*share*sum(halves)
            end if
         end do
         share = 0.5_wp*share
         if (found > most .or. depth == deepest) mean = mean + share*sum(next_means(:found))
         if (present(doubt)) doubt = differences
         if (found == 0 .or. found > most) return
         if (found > few_rough) exact = coarse
         rough = found
         ends(:, :rough) = next_ends(:, :rough)
         branches(:, :rough) = next_branches(:, :rough)
         means(:rough) = next_means(:rough)
         spans(:, :rough) = next_spans(:, :rough)
      end do

   contains

      !> Whether the law may be something in an interval that its points do not show: its bounds lie beyond them, and do not
      !> shrink in a half of it.
      pure logical function may_hide(ends, span, middle, values, share) result(may)
         !> Of the interval, and the least and largest value at its points
         real(wp), intent(in) :: ends(2), span(2)
         !> The same of its halves
         real(wp), intent(in) :: middle, values(2, 2)
         !> Part of the way
         real(wp), intent(in) :: share
         real(wp) :: beyond
         beyond = excess_of(law, sign*ends(1) + shift, sign*ends(2) + shift, span)
         may = share*beyond > negligible*level
         if (may) may = max(excess_of(law, sign*ends(1) + shift, sign*middle + shift, values(:, 1)), &
            & excess_of(law, sign*middle + shift, sign*ends(2) + shift, values(:, 2))) > shrinks*beyond
      end function may_hide

   end subroutine find_law_mean

   !> The branches that a law of one variable takes behind a value, on the way from start to end; -1 if it has none.
   pure integer(long) function branch_at(law, sign, shift, value, way) result(branch)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: sign(:), shift(:), value, way
      type(jet_type) :: line(most_slots)
      integer :: k
      do k = 1, size(sign)
         line(k)%value = sign(k)*value + shift(k)
         line(k)%first = sign(k)*way
      end do
      branch = law%branches_along(line(:size(sign)))
   end function branch_at

   !> Gauss's formula for the mean over an interval, and the largest value so far.
   pure subroutine gauss_mean(law, sign, shift, ends, mean, span, level)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: sign(:), shift(:)
      real(wp), intent(in) :: ends(2)
      real(wp), intent(out) :: mean
      !> Least and largest value at the points
      real(wp), intent(out) :: span(2)
      real(wp), intent(inout) :: level
      real(wp) :: values(most_slots), f
      integer :: k
      mean = 0.0_wp
      span = [huge(f), -huge(f)]
      do k = 1, size(gauss)
         f = 0.5_wp*(ends(1) + ends(2)) + 0.5_wp*(ends(2) - ends(1))*gauss(k)
         values(:size(sign)) = sign*f + shift
         f = law%evaluate(values(:size(sign)))
         mean = mean + 0.5_wp*gauss_weights(k)*f
         level = max(level, abs(f))
         span = [min(span(1), f), max(span(2), f)]
      end do
   end subroutine gauss_mean

   !> By how much the bounds of a law lie beyond two values while its slots are between two places; where it may be undefined there
   !> by any number.
   pure real(wp) function excess_of(law, first, second, span) result(excess)
      type(expression_type), intent(in) :: law
      !> Slots at both places
      real(wp), intent(in) :: first(:), second(:)
      !> The lower and the higher one
      real(wp), intent(in) :: span(2)
      type(range_type) :: range
      logical :: halting(size(ieee_all)), flags(size(ieee_all))
      excess = huge(excess)
      ! Bounds may overflow where the law does not
      call ieee_get_halting_mode(ieee_all, halting)
      call ieee_get_flag(ieee_all, flags)
      call ieee_set_halting_mode(ieee_all, .false.)
      range = law_range_over(law, min(first, second), max(first, second))
      if (range%defined) excess = min(huge(excess), max(0.0_wp, span(1) - range%low, range%high - span(2)))
      call ieee_set_flag(ieee_all, flags)
      call ieee_set_halting_mode(ieee_all, halting)
   end function excess_of

end module limber_multibody_law_means
