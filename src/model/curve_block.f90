!> Curves of the deck: *CURVE, by points or an expression. Floor: model.
module limber_model_curve_block
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_content, only: block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_model_curve, only: curve_type, spline_curve, expression_curve
   implicit none
   private
   public :: read_curve, check_curve

contains

   !> Reports what is wrong with a curve, whether a joint uses it or not.
   subroutine check_curve(block, diagnostics)
      type(block_type), intent(in) :: block
      type(diagnostics_type), intent(inout) :: diagnostics
      type(curve_type) :: unused
      call read_curve(block, unused, diagnostics)
   end subroutine check_curve

   !> Makes a curve from its block; unchanged after an error.
   subroutine read_curve(block, curve, diagnostics)
      type(block_type), intent(in) :: block
      type(curve_type), intent(inout) :: curve
      type(diagnostics_type), intent(inout) :: diagnostics
      !> A closed curve may repeat its first point; round-off of it beside the coordinates
      real(wp), parameter :: same = 1.0e-12_wp
      real(wp), allocatable :: points(:, :)
      integer :: i, n
      associate (lines => block%lines)
         n = size(lines)
         if (n == 1) then
            if (size(lines(1)%fields) == 1) then
               if (block%yes('CLOSED')) call diagnostics%add(block%origin_of('CLOSED'), &
                  & 'CLOSED means nothing of a curve by an expression', 'leave it out, or give points x, y')
               curve = expression_curve(lines(1)%fields(1)%expression)
               return
            end if
         end if
         allocate (points(2, n))
         do i = 1, n
            if (size(lines(i)%fields) < 2 .or. .not. lines(i)%fields(1)%expression%is_constant()) then
               call diagnostics%add(lines(i)%origin, "curve '"//block%name()//"' has a line that is no point", &
                  & 'give points x, y; or one line alone with y as an expression of x')
               return
            end if
            points(1, i) = lines(i)%fields(1)%expression%constant_value()
            points(2, i) = lines(i)%fields(2)%value
            if (i > 1) then
               if (.not. norm2(points(:, i) - points(:, i - 1)) > 0.0_wp) then
                  call diagnostics%add(lines(i)%origin, 'this point is the one before it', 'remove one of the two')
                  return
               end if
            end if
         end do
         if (n > 1 .and. block%yes('CLOSED')) then
            if (norm2(points(:, n) - points(:, 1)) <= same*maxval(abs(points))) n = n - 1
         end if
         if (n < 3) then
            call diagnostics%add(block%origin, "curve '"//block%name()//"' has "//as_text(n)//' points', 'give at least three')
            return
         end if
         curve = spline_curve(points(:, :n), block%yes('CLOSED'))
      end associate
   end subroutine read_curve

end module limber_model_curve_block
