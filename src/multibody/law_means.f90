!> Means of a law of one variable between two values of it. They are the force over a step whose work is exact, and the energy of
!> the law. Floor: multibody. Source: doc/theory, eqs. (3.35), (3.36).
module limber_multibody_law_means
   use limber_base_kinds, only: wp, long
   use limber_deck_expression, only: expression_type
   use limber_deck_operations, only: jet_type
   use limber_model_model, only: most_slots
   implicit none
   private
   public :: mean_law, find_law_mean

   !> Gauss points and weights on -1..1, how often an interval is halved at most, and how many may be rough
   real(wp), parameter :: gauss(5) = [-0.906179845938663993_wp, -0.538469310105683091_wp, 0.0_wp, 0.538469310105683091_wp, &
      & 0.906179845938663993_wp]
   real(wp), parameter :: gauss_weights(5) = [0.236926885056189088_wp, 0.478628670499366468_wp, 0.568888888888888889_wp, &
      & 0.478628670499366468_wp, 0.236926885056189088_wp]
   integer, parameter :: deepest = 40, most_rough = 64

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
      call find_law_mean(law, sign, shift, start, end, mean, open)
   end function mean_law

   !> The same, and how much of it, in size, comes from the intervals that were not small enough at last.
   pure subroutine find_law_mean(law, sign, shift, start, end, mean, open)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: sign(:), shift(:)
      real(wp), intent(in) :: start, end
      real(wp), intent(out) :: mean, open
      !> Ends of the intervals that are rough, branches there and means over them
      real(wp) :: ends(2, most_rough), means(most_rough)
      real(wp) :: next_ends(2, 2*most_rough), next_means(2*most_rough)
      integer(long) :: branches(2, most_rough), next_branches(2, 2*most_rough), between
      real(wp) :: middle, halves(2), level, share
      integer :: i, rough, found, depth
      mean = 0.0_wp
      open = 0.0_wp
      level = 0.0_wp
      share = 1.0_wp
      rough = 1
      between = -1
      ends(:, 1) = [start, end]
      branches(1, 1) = branch_at(law, sign, shift, start, end - start)
      branches(2, 1) = branches(1, 1)
      if (branches(1, 1) >= 0) branches(2, 1) = branch_at(law, sign, shift, end, end - start)
      call gauss_mean(law, sign, shift, ends(:, 1), means(1), level)
      do depth = 1, deepest
         found = 0
         do i = 1, rough
            middle = ends(1, i) + 0.5_wp*(ends(2, i) - ends(1, i))
            call gauss_mean(law, sign, shift, [ends(1, i), middle], halves(1), level)
            call gauss_mean(law, sign, shift, [middle, ends(2, i)], halves(2), level)
            if (branches(1, 1) >= 0) between = branch_at(law, sign, shift, middle, end - start)
            if (share*abs(0.5_wp*sum(halves) - means(i)) > 1.0e-15_wp*level .or. any(branches(:, i) /= between)) then
               next_ends(:, found + 1) = [ends(1, i), middle]
               next_ends(:, found + 2) = [middle, ends(2, i)]
               next_branches(:, found + 1) = [branches(1, i), between]
               next_branches(:, found + 2) = [between, branches(2, i)]
               next_means(found + 1:found + 2) = halves
               found = found + 2
            else
               mean = mean + 0.5_wp*share*sum(halves)
            end if
         end do
         share = 0.5_wp*share
         if (found > most_rough .or. depth == deepest) then
            mean = mean + share*sum(next_means(:found))
            open = share*sum(abs(next_means(:found)))
         end if
         if (found == 0 .or. found > most_rough) return
         rough = found
         ends(:, :rough) = next_ends(:, :rough)
         branches(:, :rough) = next_branches(:, :rough)
         means(:rough) = next_means(:rough)
      end do
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
   pure subroutine gauss_mean(law, sign, shift, ends, mean, level)
      type(expression_type), intent(in) :: law
      real(wp), intent(in) :: sign(:), shift(:)
      real(wp), intent(in) :: ends(2)
      real(wp), intent(out) :: mean
      real(wp), intent(inout) :: level
      real(wp) :: values(most_slots), f
      integer :: k
      mean = 0.0_wp
      do k = 1, size(gauss)
         f = 0.5_wp*(ends(1) + ends(2)) + 0.5_wp*(ends(2) - ends(1))*gauss(k)
         values(:size(sign)) = sign*f + shift
         f = law%evaluate(values(:size(sign)))
         mean = mean + 0.5_wp*gauss_weights(k)*f
         level = max(level, abs(f))
      end do
   end subroutine gauss_mean

end module limber_multibody_law_means
