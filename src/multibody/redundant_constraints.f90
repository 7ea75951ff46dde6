!> Redundant constraints: null space of the transposed Jacobian. The null space of G^T, from singular values in small scenes, by
!> inverse iteration with sparse factors in large ones; and what it means for the joints, by name. Floor: multibody. Source:
!> doc/theory, eqs. (4.29)-(4.31).
module limber_multibody_redundant_constraints
   use limber_base_kinds, only: wp
   use limber_base_finite, only: dgesvd
   use limber_base_text, only: as_text
   use limber_multibody_constraint_matrix, only: constraint_matrix_type, solve_damped, transposed_times, full_matrix, small_square
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: redundancy_type, find_redundancy, group_names, constraint_names

   !> Share in a combination below which an equation is no part of it
   real(wp), parameter :: no_share = 1.0e-5_wp

   !> Equations that others imply
   type :: redundancy_type
      !> Number of equations that can go
      integer :: count = 0
      !> Of each constraint: the group of constraints that it shares redundant equations with; 0: it has none (constraints)
      integer, allocatable :: group(:)
      !> Number of redundant equations of each group, and the last constraint that repeats others (groups)
      integer, allocatable :: excess(:), last(:)
   end type redundancy_type

contains

   !> Groups of constraints that share redundant equations. The matrix is filled.
   subroutine find_redundancy(system, matrix, found)
      type(system_type), intent(in) :: system
      type(constraint_matrix_type), intent(inout) :: matrix
      type(redundancy_type), intent(out) :: found
      real(wp), allocatable :: null(:, :)
      integer, allocatable :: owner(:), pivot(:)
      integer :: i, k, constraints
      constraints = size(system%constraints)
      allocate (found%group(constraints), owner(matrix%rows))
      found%group = 0
      do i = 1, constraints
         associate (item => system%constraints(i)%item)
            if (item%part_of > 0) cycle
            owner(item%first:item%first + item%rows - 1) = i
         end associate
      end do
      call find_null_space(matrix, null)
      found%count = size(null, 2)
      if (found%count == 0) then
         allocate (found%excess(0), found%last(0))
         return
      end if
      allocate (pivot(found%count))
      call name_rows(null, pivot)
      call join_groups(owner, null, found)
      do k = 1, found%count
         i = found%group(owner(pivot(k)))
         found%excess(i) = found%excess(i) + 1
         found%last(i) = max(found%last(i), owner(pivot(k)))
      end do
   end subroutine find_redundancy

   !> Combines vectors until each has a row of its own, which it alone contains: late rows, so that the first constraint that
   !> demands a thing is not the one that repeats it.
   subroutine name_rows(null, pivot)
      !> Orthonormal columns; out: one at the row of each (rows, count)
      real(wp), intent(inout) :: null(:, :)
      integer, intent(out) :: pivot(:)
      real(wp) :: largest, here
      integer :: j, k, row, best
      do k = 1, size(pivot)
         largest = 0.0_wp
         do row = 1, size(null, 1)
            largest = max(largest, maxval(abs(null(row, k:))))
         end do
         do row = size(null, 1), 1, -1
            here = maxval(abs(null(row, k:)))
            if (here > 0.3_wp*largest) exit
         end do
         pivot(k) = row
         best = k - 1 + maxloc(abs(null(row, k:)), dim=1)
         null(:, [k, best]) = null(:, [best, k])
         null(:, k) = null(:, k)/null(row, k)
         do j = 1, size(pivot)
            if (j == k) cycle
            null(:, j) = null(:, j) - null(row, j)*null(:, k)
         end do
      end do
   end subroutine name_rows

   !> Constraints that stand in one combination belong to one group.
   pure subroutine join_groups(owner, null, found)
      !> Constraint of each row (rows)
      integer, intent(in) :: owner(:)
      real(wp), intent(in) :: null(:, :)
      type(redundancy_type), intent(inout) :: found
      integer :: parent(size(found%group)), number(size(found%group))
      integer :: i, k, row, first, count
      parent = [(i, i=1, size(parent))]
      do k = 1, size(null, 2)
         first = 0
         do row = 1, size(null, 1)
            if (abs(null(row, k)) <= no_share) cycle
            if (first == 0) first = root(owner(row))
            parent(root(owner(row))) = root(first)
            found%group(owner(row)) = 1
         end do
      end do
      number = 0
      count = 0
      do i = 1, size(parent)
         if (found%group(i) == 0) cycle
         if (number(root(i)) == 0) then
            count = count + 1
            number(root(i)) = count
         end if
         found%group(i) = number(root(i))
      end do
      allocate (found%excess(count), found%last(count))
      found%excess = 0
      found%last = 0

   contains

      pure integer function root(member)
         integer, intent(in) :: member
         root = member
         do while (parent(root) /= root)
            root = parent(root)
         end do
      end function root

   end subroutine join_groups

   !> Orthonormal combinations of rows that are zero: null^T G = 0. Their number is the number of rows less the rank.
   subroutine find_null_space(matrix, null)
      type(constraint_matrix_type), intent(inout) :: matrix
      !> (rows, count)
      real(wp), allocatable, intent(out) :: null(:, :)
      if (matrix%rows == 0) then
         allocate (null(0, 0))
      else if (matrix%dense) then
         call null_space_by_values(matrix, null)
      else
         call null_space_by_iteration(matrix, null)
      end if
   end subroutine find_null_space

   !> By singular values.
   subroutine null_space_by_values(matrix, null)
      type(constraint_matrix_type), intent(in) :: matrix
      real(wp), allocatable, intent(out) :: null(:, :)
      real(wp), allocatable :: full(:, :), values(:), left(:, :), right(:, :), buffer(:)
      integer :: m, n, info, rank
      m = matrix%rows
      n = matrix%columns
      allocate (full, source=full_matrix(matrix))
      allocate (values(max(m, n)), left(m, m), right(1, 1), buffer(10*(m + n) + 64*(m + n)))
      values = 0.0_wp
      call dgesvd('A', 'N', m, n, full, m, values, left, m, right, 1, buffer, size(buffer), info)
      rank = count(values(:min(m, n)) > matrix%nothing*matrix%norm)
      if (info /= 0) rank = m
      allocate (null(m, m - rank))
      null = left(:, rank + 1:)
   end subroutine null_space_by_values

   !> By inverse iteration on a block of vectors that grows until it has some outside the null space.
   subroutine null_space_by_iteration(matrix, null)
      type(constraint_matrix_type), intent(inout) :: matrix
      real(wp), allocatable, intent(out) :: null(:, :)
      integer, parameter :: rounds = 4
      real(wp), allocatable :: block(:, :), unknown(:), image(:, :), values(:), left(:, :), right(:, :), buffer(:)
      integer :: wide, k, round, info, found
      wide = min(4, matrix%rows)
      allocate (unknown(matrix%columns + matrix%rows))
      do
         allocate (block(matrix%rows, wide), image(matrix%columns, wide), values(wide), left(1, 1), right(wide, wide))
         allocate (buffer(10*wide + 64*(matrix%columns + wide)))
         call scatter(block)
         do round = 1, rounds
            call orthonormalise(block)
            do k = 1, wide
               unknown(:matrix%columns) = 0.0_wp
               unknown(matrix%columns + 1:) = block(:, k)
               call solve_damped(matrix, small_square*matrix%norm**2, unknown)
               block(:, k) = unknown(matrix%columns + 1:)
            end do
         end do
         call orthonormalise(block)
         do k = 1, wide
            image(:, k) = transposed_times(matrix, block(:, k))
         end do
         values = 0.0_wp
         call dgesvd('N', 'A', matrix%columns, wide, image, matrix%columns, values, left, 1, right, wide, buffer, size(buffer), &
            & info)
         found = count(values <= matrix%nothing*matrix%norm)
         if (info /= 0) found = 0
         if (found < wide .or. wide == matrix%rows) exit
         wide = min(4*wide, matrix%rows)
         deallocate (block, image, values, left, right, buffer)
      end do
      allocate (null(matrix%rows, found))
      null = matmul(block, transpose(right(wide - found + 1:, :)))
   end subroutine null_space_by_iteration

   !> Vectors without any order, the same in every run.
   pure subroutine scatter(block)
      real(wp), intent(out) :: block(:, :)
      integer, parameter :: modulus = 2147483647, long = selected_int_kind(18)
      integer :: i, k, seed
      seed = 20240229
      do k = 1, size(block, 2)
         do i = 1, size(block, 1)
            seed = int(modulo(16807_long*int(seed, long), int(modulus, long)))
            block(i, k) = 2*real(seed, wp)/modulus - 1
         end do
      end do
   end subroutine scatter

   !> Columns of unit length, at right angles to each other; twice is enough.
   pure subroutine orthonormalise(block)
      real(wp), intent(inout) :: block(:, :)
      integer :: j, k, round
      do k = 1, size(block, 2)
         block(:, k) = block(:, k)/norm2(block(:, k))
         do round = 1, 2
            do j = 1, k - 1
               block(:, k) = block(:, k) - dot_product(block(:, j), block(:, k))*block(:, j)
            end do
            block(:, k) = block(:, k)/norm2(block(:, k))
         end do
      end do
   end subroutine orthonormalise

   !> Labels of the constraints of a group: "joint 'a', joint 'b' and 3 more".
   pure function group_names(system, found, group) result(text)
      type(system_type), intent(in) :: system
      type(redundancy_type), intent(in) :: found
      integer, intent(in) :: group
      character(:), allocatable :: text
      text = constraint_names(system, found%group == group)
   end function group_names

   !> Labels of some constraints.
   pure function constraint_names(system, chosen) result(text)
      type(system_type), intent(in) :: system
      !> Which (constraints)
      logical, intent(in) :: chosen(:)
      character(:), allocatable :: text
      integer, parameter :: most = 12
      integer :: i, named, all_of_them
      text = ''
      named = 0
      all_of_them = 0
      do i = 1, size(chosen)
         if (chosen(i) .and. system%constraints(i)%item%part_of == 0) all_of_them = all_of_them + 1
      end do
      do i = 1, size(chosen)
         if (.not. chosen(i) .or. system%constraints(i)%item%part_of > 0) cycle
         named = named + 1
         if (named > most .and. all_of_them > most + 1) then
            text = text//' and '//as_text(all_of_them - most)//' more'
            return
         end if
         if (named > 1 .and. named == all_of_them) then
            text = text//' and '
         else if (named > 1) then
            text = text//', '
         end if
         text = text//system%constraints(i)%item%label
      end do
   end function constraint_names

end module limber_multibody_redundant_constraints
