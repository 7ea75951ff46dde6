!> Axial coordinates that follow at rest, in the equations of implicit integrators: the rows of the axial coordinates are added to
!> those of the bending by H^T, and in their place stand eta_a' = H eta_b' (eta_a' = 0 in the models linear and k_g). With exact
!> derivatives; the pattern of the matrix stays. Floor: system. Source: doc/theory, eqs. (141), (145).
module limber_system_condensed_motion
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_flex_folding, only: fold_matrix, fold_curvature
   use limber_system_condensation, only: update_folds
   use limber_system_system, only: system_type, workspace_type
   use limber_system_tangent, only: tangent_type
   implicit none
   private
   public :: condensed_rows_type, new_condensed_rows, condense_residual, condense_tangent, condense_right_side

   !> Where the rows of one body's deflections stand in the matrix
   type :: row_places_type
      !> For each column that has them, their places (n, columns); of the columns of the deflections themselves (n)
      integer, allocatable :: place(:, :), own(:)
      !> Scratch: H for the rates (axial, bending), curvature (bending, bending)
      real(wp), allocatable :: turn(:, :), curvature(:, :)
   end type row_places_type

   !> The same of all bodies; those without condensed coordinates have no places
   type :: condensed_rows_type
      type(row_places_type), allocatable :: bodies(:)
   contains
      procedure :: exchange => exchange_condensed_rows
   end type condensed_rows_type

contains

   !> Finds the rows in the pattern.
   subroutine new_condensed_rows(system, tangent, rows)
      type(system_type), intent(in) :: system
      type(tangent_type), intent(in) :: tangent
      type(condensed_rows_type), intent(inout) :: rows
      integer :: i, k, column, count, first, n, b
      allocate (rows%bodies(size(system%layout%q)))
      do i = 1, size(rows%bodies)
         if (.not. system%model%bodies(i)%reduced%condensed) cycle
         n = system%layout%n(i)
         b = system%model%bodies(i)%reduced%bending
         first = system%layout%w(i) + 2
         count = 0
         do column = 1, tangent%matrix%n
            if (tangent%matrix%holds(first + 1, column)) count = count + 1
         end do
         associate (body => rows%bodies(i))
            allocate (body%place(n, count), body%own(n), body%turn(n - b, b), body%curvature(b, b))
            count = 0
            do column = 1, tangent%matrix%n
               if (.not. tangent%matrix%holds(first + 1, column)) cycle
               count = count + 1
               do k = 1, n
                  body%place(k, count) = tangent%matrix%place(first + k, column)
               end do
               if (column > first .and. column <= first + n) body%own(column - first) = count
            end do
         end associate
      end do
   end subroutine new_condensed_rows

   !> Residual of the motions that are left, eq. (141), from that of all; keeps the axial loads.
   subroutine condense_residual(system, work, q, v, motion)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Coordinates and velocities (nq)
      real(wp), intent(in) :: q(:), v(:)
      !> Residual of the motion (nw)
      real(wp), intent(inout) :: motion(:)
      integer :: i, j, k, b, row, at
      call update_folds(system, work, q)
      do i = 1, size(work%bodies)
         associate (reduced => system%model%bodies(i)%reduced, body => work%bodies(i))
            if (.not. reduced%condensed) cycle
            b = reduced%bending
            row = system%layout%w(i) + 2
            at = system%layout%q(i) + 3
            do k = 1, reduced%n - b
               body%load(k) = -motion(row + b + k)
            end do
            do j = 1, b
               do k = 1, reduced%n - b
                  motion(row + j) = motion(row + j) - body%fold(k, j)*body%load(k)
               end do
            end do
            do k = 1, reduced%n - b
               motion(row + b + k) = v(at + b + k)
               if (.not. reduced%full) cycle
               do j = 1, b
                  motion(row + b + k) = motion(row + b + k) - body%fold(k, j)*v(at + j)
               end do
            end do
         end associate
      end do
   end subroutine condense_residual

   !> The same of a right-hand side without residuals of the axial rates (nw).
   pure subroutine condense_right_side(system, work, vector)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      real(wp), intent(inout) :: vector(:)
      integer :: i, j, k, b, row
      do i = 1, size(work%bodies)
         associate (reduced => system%model%bodies(i)%reduced, body => work%bodies(i))
            if (.not. reduced%condensed) cycle
            b = reduced%bending
            row = system%layout%w(i) + 2
            do j = 1, b
               do k = 1, reduced%n - b
                  vector(row + j) = vector(row + j) + body%fold(k, j)*vector(row + b + k)
               end do
            end do
            vector(row + b + 1:row + reduced%n) = 0.0_wp
         end associate
      end do
   end subroutine condense_right_side

   !> Derivatives of that residual, from those of all motions as `linearise_motion` leaves them, eq. (145).
   subroutine condense_tangent(system, work, rows, q, v, tangent)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(condensed_rows_type), intent(inout) :: rows
      !> Coordinates and velocities (nq)
      real(wp), intent(in) :: q(:), v(:)
      type(tangent_type), intent(inout) :: tangent
      integer :: i, j, k, b, part, column, at
      call update_folds(system, work, q)
      do i = 1, size(work%bodies)
         associate (reduced => system%model%bodies(i)%reduced, body => work%bodies(i), places => rows%bodies(i))
            if (.not. reduced%condensed) cycle
            b = reduced%bending
            at = system%layout%q(i) + 3
            do part = 1, size(tangent%parts, 2)
               do column = 1, size(places%place, 2)
                  call add_rows(body%fold, places%place(:, column), tangent%parts(:, part))
               end do
            end do
            places%curvature = 0.0_wp
            call fold_curvature(reduced, body%load, places%curvature)
            places%turn = 0.0_wp
            if (reduced%full) call fold_matrix(reduced, v(at + 1:at + b), places%turn)
            do j = 1, b
               associate (place => places%place(:, places%own(j)))
                  do k = 1, b
                     tangent%parts(place(k), 3) = tangent%parts(place(k), 3) + places%curvature(k, j)
                  end do
                  do k = 1, reduced%n - b
                     if (reduced%full) tangent%parts(place(b + k), 2) = -body%fold(k, j)
                     tangent%parts(place(b + k), 3) = -places%turn(k, j)
                  end do
               end associate
            end do
            do k = b + 1, reduced%n
               tangent%parts(places%place(k, places%own(k)), 2) = 1.0_wp
            end do
         end associate
      end do
   end subroutine condense_tangent

   !> Adds the axial entries of a column to those of the bending, and clears them.
   pure subroutine add_rows(fold, place, entries)
      real(wp), intent(in) :: fold(:, :)
      integer, intent(in) :: place(:)
      real(wp), intent(inout) :: entries(:)
      integer :: j, k, b
      b = size(fold, 2)
      do j = 1, b
         do k = 1, size(fold, 1)
            entries(place(j)) = entries(place(j)) + fold(k, j)*entries(place(b + k))
         end do
      end do
      do k = 1, size(fold, 1)
         entries(place(b + k)) = 0.0_wp
      end do
   end subroutine add_rows

   !> Saves or restores its memory.
   subroutine exchange_condensed_rows(self, snapshot)
      class(condensed_rows_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      integer :: i
      if (.not. allocated(self%bodies)) return
      do i = 1, size(self%bodies)
         call snapshot%keep('turn', self%bodies(i)%turn)
         call snapshot%keep('curvature', self%bodies(i)%curvature)
      end do
   end subroutine exchange_condensed_rows

end module limber_system_condensed_motion
